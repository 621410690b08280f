//! Polygon files (PLY 1.0, Turk 1994): ASCII and binary of both byte orders.

use super::{ImportError, push_part, unit_normal};
use crate::{MAX_TRIANGLES, Mesh};

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn size_bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The value that stands for full intensity in a colour of this type.
    fn full(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32_767.0,
            Self::U16 => 65_535.0,
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::F32 | Self::F64 => 1.0,
        }
    }
}

struct Property {
    name: String,
    /// The type of the length, for a list.
    list: Option<Scalar>,
    scalar: Scalar,
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

impl Element {
    /// Fewest bytes one instance can take.
    fn least_bytes(&self, format: Format) -> u64 {
        let sum: usize = self
            .properties
            .iter()
            .map(|property| match format {
                // One digit and what separates it from the next.
                Format::Ascii => 2,
                _ => property.list.unwrap_or(property.scalar).size_bytes(),
            })
            .sum();
        sum as u64
    }

    fn find(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|property| property.name == name && property.list.is_none())
    }
}

/// Reads a PLY file that is already in memory.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, ImportError> {
    let (format, elements, mut body) = read_header(bytes)?;
    // Counts are believed only as far as the file is long.
    for element in &elements {
        let least = element.least_bytes(format).saturating_mul(element.count);
        let there = body.bytes.len() as u64 + 1;
        if least > there {
            let problem = format!("{} of them need {least} bytes, {there} left", element.count);
            return Err(ImportError::invalid(format!("element `{}`", element.name), problem));
        }
    }
    let count = elements.iter().find(|element| element.name == "vertex").map(|e| e.count);
    let Some(count) = count else {
        return Err(ImportError::invalid("header", "no element `vertex`"));
    };

    let mut vertices = Vertices::default();
    let mut indices = None;
    for element in &elements {
        match element.name.as_str() {
            "vertex" => vertices = read_vertices(element, &mut body)?,
            "face" => indices = Some(read_faces(element, count, &mut body)?),
            _ => {
                for i in 0..element.count {
                    body.instance(element, i, |_, _, _| Ok(()))?;
                }
            }
        }
    }
    if !body.only_blanks_left() {
        return Err(ImportError::invalid(body.place(), "more data than the header says"));
    }
    let Some(indices) = indices else {
        return Err(ImportError::invalid("header", "no element `face`"));
    };
    let mut mesh = Mesh::default();
    let Vertices { positions, normals, rgba } = &vertices;
    push_part(&mut mesh, "element `face`", positions, normals.as_deref(), rgba, &indices)?;
    Ok(mesh)
}

fn read_header(bytes: &[u8]) -> Result<(Format, Vec<Element>, Body<'_>), ImportError> {
    let mut rest = bytes;
    let mut line_number = 0;
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        line_number += 1;
        let place = format!("line {line_number}");
        let invalid = |problem: &str| ImportError::invalid(place.clone(), problem);
        let Some(end) = rest.iter().position(|byte| *byte == b'\n') else {
            return Err(invalid("the header has no `end_header`"));
        };
        let (line, after) = (&rest[..end], &rest[end + 1..]);
        rest = after;
        let line = std::str::from_utf8(line).map_err(|_| invalid("the header is not text"))?;
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        if line_number == 1 {
            if words != ["ply"] {
                return Err(invalid("not a PLY file"));
            }
            continue;
        }
        match words.as_slice() {
            [] | ["comment" | "obj_info", ..] => {}
            ["end_header"] => break,
            ["format", word, "1.0"] => {
                format = Some(match *word {
                    "ascii" => Format::Ascii,
                    "binary_little_endian" => Format::LittleEndian,
                    "binary_big_endian" => Format::BigEndian,
                    _ => return Err(invalid(&format!("unknown format `{word}`"))),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| invalid("bad element count"))?;
                if elements.iter().any(|element| element.name == *name) {
                    return Err(invalid(&format!("a second element `{name}`")));
                }
                elements.push(Element { name: (*name).into(), count, properties: Vec::new() });
            }
            ["property", types @ .., name] => {
                let scalar = |word: &str| {
                    Scalar::parse(word).ok_or_else(|| invalid(&format!("unknown type `{word}`")))
                };
                let (list, scalar) = match types {
                    [word] => (None, scalar(word)?),
                    ["list", length, word] => (Some(scalar(length)?), scalar(word)?),
                    _ => return Err(invalid("a property is `property type name`")),
                };
                let Some(element) = elements.last_mut() else {
                    return Err(invalid("a property before the first element"));
                };
                element.properties.push(Property { name: (*name).into(), list, scalar });
            }
            _ => return Err(invalid(&format!("unknown header line `{line}`"))),
        }
    }
    if let Some(element) = elements.iter().find(|element| element.properties.is_empty()) {
        let place = format!("element `{}`", element.name);
        return Err(ImportError::invalid(place, "no properties"));
    }
    let format = format.ok_or_else(|| ImportError::invalid("header", "no `format` line"))?;
    Ok((format, elements, Body { format, bytes: rest, line_number }))
}

/// The bytes after the header, read from the front.
struct Body<'a> {
    format: Format,
    bytes: &'a [u8],
    /// Of the last line read (ASCII).
    line_number: usize,
}

impl<'a> Body<'a> {
    fn place(&self) -> String {
        match self.format {
            Format::Ascii => format!("line {}", self.line_number),
            _ => "after the last element".into(),
        }
    }

    /// Reads one instance of an element: `visit(property index, value, position in list)` for
    /// every value; lists are announced by nothing, their values by a position.
    fn instance(
        &mut self,
        element: &Element,
        i: u64,
        mut visit: impl FnMut(usize, f64, Option<usize>) -> Result<(), String>,
    ) -> Result<(), ImportError> {
        let result = if self.format == Format::Ascii {
            self.next_line().and_then(|line| {
                let mut words = line.split_ascii_whitespace();
                walk(element, &mut visit, &mut |_| {
                    let word = words.next().ok_or("too few values")?;
                    word.parse().map_err(|_| format!("`{word}` is not a number"))
                })?;
                words.next().map_or(Ok(()), |word| Err(format!("`{word}` is one value too many")))
            })
        } else {
            walk(element, &mut visit, &mut |scalar| self.binary(scalar))
        };
        result.map_err(|problem| {
            let place = match self.format {
                Format::Ascii => format!("line {}, {} {i}", self.line_number, element.name),
                _ => format!("{} {i}", element.name),
            };
            ImportError::invalid(place, problem)
        })
    }

    /// The next line that is not blank.
    fn next_line(&mut self) -> Result<&'a str, String> {
        loop {
            if self.bytes.is_empty() {
                return Err("the file ends here".into());
            }
            self.line_number += 1;
            let end = self.bytes.iter().position(|byte| *byte == b'\n');
            let line = &self.bytes[..end.unwrap_or(self.bytes.len())];
            self.bytes = end.map_or(&[], |end| &self.bytes[end + 1..]);
            if !line.trim_ascii().is_empty() {
                return std::str::from_utf8(line).map_err(|_| "not text".into());
            }
        }
    }

    fn binary(&mut self, scalar: Scalar) -> Result<f64, String> {
        let size = scalar.size_bytes();
        let Some((value, rest)) = self.bytes.split_at_checked(size) else {
            return Err("the file ends here".into());
        };
        self.bytes = rest;
        let mut bytes = [0; 8];
        bytes[..size].copy_from_slice(value);
        if self.format == Format::BigEndian {
            bytes[..size].reverse();
        }
        let [a, b, c, d, ..] = bytes;
        Ok(match scalar {
            Scalar::I8 => f64::from(i8::from_le_bytes([a])),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::F64 => f64::from_le_bytes(bytes),
        })
    }

    fn only_blanks_left(&self) -> bool {
        match self.format {
            Format::Ascii => self.bytes.trim_ascii().is_empty(),
            _ => self.bytes.is_empty(),
        }
    }
}

/// Reads the values of one instance with `next` and hands each to `visit`.
fn walk(
    element: &Element,
    visit: &mut impl FnMut(usize, f64, Option<usize>) -> Result<(), String>,
    next: &mut impl FnMut(Scalar) -> Result<f64, String>,
) -> Result<(), String> {
    for (i, property) in element.properties.iter().enumerate() {
        let Some(length) = property.list else {
            visit(i, next(property.scalar)?, None)?;
            continue;
        };
        let length = whole(next(length)?).ok_or("a list length must be a whole number")?;
        // No allocation here: a false length runs into the end of the file.
        for position in 0..length {
            visit(i, next(property.scalar)?, Some(position as usize))?;
        }
    }
    Ok(())
}

fn whole(value: f64) -> Option<u32> {
    (value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value)).then_some(value as u32)
}

#[derive(Default)]
struct Vertices {
    positions: Vec<[f32; 3]>,
    normals: Option<Vec<[f32; 3]>>,
    rgba: Vec<[u8; 4]>,
}

fn read_vertices(element: &Element, body: &mut Body<'_>) -> Result<Vertices, ImportError> {
    let all = |names: [&str; 3]| {
        let [x, y, z] = names.map(|name| element.find(name));
        Some([x?, y?, z?])
    };
    let Some(xyz) = all(["x", "y", "z"]) else {
        return Err(ImportError::invalid("element `vertex`", "no properties x, y and z"));
    };
    let normal = all(["nx", "ny", "nz"]);
    let rgb = all(["red", "green", "blue"]);
    let alpha = element.find("alpha");

    let count = element.count as usize;
    let mut vertices = Vertices {
        positions: Vec::with_capacity(count),
        normals: normal.map(|_| Vec::with_capacity(count)),
        rgba: Vec::with_capacity(count),
    };
    let mut values = vec![0.0; element.properties.len()];
    for i in 0..element.count {
        body.instance(element, i, |property, value, position| {
            if position.is_none() {
                values[property] = value;
            }
            let is_coordinate =
                xyz.contains(&property) || normal.is_some_and(|n| n.contains(&property));
            if is_coordinate && !(value as f32).is_finite() {
                let name = &element.properties[property].name;
                return Err(format!("`{name}` is {value}, not a finite float"));
            }
            Ok(())
        })?;
        vertices.positions.push(xyz.map(|p| values[p] as f32));
        if let (Some(normals), Some(normal)) = (&mut vertices.normals, normal) {
            // Finite, as checked above.
            normals.extend(unit_normal(normal.map(|p| values[p] as f32)));
        }
        // A NaN becomes 0: `as` saturates.
        let channel =
            |p: usize| (values[p] / element.properties[p].scalar.full() * 255.0).round() as u8;
        let [r, g, b] = rgb.map_or([255; 3], |rgb| rgb.map(channel));
        vertices.rgba.push([r, g, b, alpha.map_or(255, channel)]);
    }
    Ok(vertices)
}

/// The triangles: polygons are cut into fans about their first corner.
fn read_faces(
    element: &Element,
    vertex_count: u64,
    body: &mut Body<'_>,
) -> Result<Vec<u32>, ImportError> {
    let list = element.properties.iter().position(|property| {
        property.list.is_some() && ["vertex_indices", "vertex_index"].contains(&&*property.name)
    });
    let Some(list) = list else {
        return Err(ImportError::invalid("element `face`", "no list `vertex_indices`"));
    };
    let mut indices = Vec::with_capacity(3 * element.count.min(MAX_TRIANGLES) as usize);
    for i in 0..element.count {
        let mut corners = 0;
        let mut fan = [0; 2];
        body.instance(element, i, |property, value, position| {
            let Some(position) = position.filter(|_| property == list) else { return Ok(()) };
            let index = whole(value).filter(|index| u64::from(*index) < vertex_count);
            let index = index
                .ok_or_else(|| format!("corner {position} is vertex {value}, of {vertex_count}"))?;
            corners = position + 1;
            if position < 2 {
                fan[position] = index;
            } else if indices.len() as u64 >= 3 * MAX_TRIANGLES {
                return Err(format!("more than {MAX_TRIANGLES} triangles"));
            } else {
                indices.extend([fan[0], fan[1], index]);
                fan[1] = index;
            }
            Ok(())
        })?;
        if corners < 3 {
            let problem = format!("{corners} corners, at least 3 are needed");
            return Err(ImportError::invalid(format!("face {i}"), problem));
        }
    }
    Ok(indices)
}
