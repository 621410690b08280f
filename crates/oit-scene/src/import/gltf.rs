//! glTF 2.0 and GLB through the `gltf` crate. Its readers trust accessors, so every accessor is
//! checked against its buffer view and buffer before a reader sees it.

use std::path::{Component, Path};

use base64::Engine;
use glam::{Mat3, Mat4, Vec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::Source;
use gltf::json::validation::Checked;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf, Primitive, Semantic};

use super::{ImportError, push_part, read_file, unit_normal};
use crate::mesh::to_byte;
use crate::{MAX_TRIANGLES, Mesh};

/// Reads a glTF or GLB file that is already in memory; buffers that it names lie in `folder`.
pub(super) fn read(bytes: &[u8], folder: &Path) -> Result<Mesh, ImportError> {
    // The crate subtracts the header from this length without looking.
    if bytes.starts_with(b"glTF") {
        let length = bytes.get(8..12).and_then(|length| length.try_into().ok());
        if length.map(u32::from_le_bytes).is_none_or(|length| length < 12) {
            return Err(ImportError::invalid("GLB header", "truncated or of no length"));
        }
    }
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(file_error)?;
    let document = validate(document)?;
    let buffers = read_buffers(&document, blob, folder)?;

    let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) else {
        return Err(ImportError::invalid("file", "no scene"));
    };
    let instances = instances(&document, scene)?;
    let mut mesh = Mesh::default();
    for Instance { what, primitive, transform } in &instances {
        push_primitive(&mut mesh, what, primitive, &buffers, *transform)?;
    }
    Ok(mesh)
}

/// One primitive of one node.
struct Instance<'a> {
    what: String,
    primitive: Primitive<'a>,
    transform: Mat4,
}

/// The primitives to draw, in the order of the file. A small file can name a large mesh many times,
/// so their sum is checked here, before any of them is made.
fn instances<'a>(
    document: &'a Document,
    scene: gltf::Scene<'a>,
) -> Result<Vec<Instance<'a>>, ImportError> {
    let mut instances = Vec::new();
    let mut total = 0;
    let mut seen = vec![false; document.nodes().len()];
    // Last in, first out, with children in reverse.
    let mut pending: Vec<_> = scene.nodes().map(|node| (node, Mat4::IDENTITY)).collect();
    pending.reverse();
    while let Some((node, parent)) = pending.pop() {
        let place = format!("node {}", node.index());
        if std::mem::replace(&mut seen[node.index()], true) {
            let problem = "reached twice: nodes must form a tree";
            return Err(ImportError::invalid(place, problem));
        }
        let transform = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        if !transform.is_finite() {
            return Err(ImportError::invalid(place, "its transform is not finite"));
        }
        if let Some(drawn) = node.mesh() {
            for primitive in drawn.primitives() {
                let what = format!("mesh {} primitive {}", drawn.index(), primitive.index());
                total += most_corners(&primitive);
                if total > 3 * MAX_TRIANGLES {
                    return Err(ImportError::TooManyTriangles { what: format!("{place}, {what}") });
                }
                instances.push(Instance { what, primitive, transform });
            }
        }
        let first_child = pending.len();
        pending.extend(node.children().map(|child| (child, transform)));
        pending[first_child..].reverse();
    }
    Ok(instances)
}

/// No fewer than the vertices and the corners that a primitive brings. A count that is too large by
/// itself is left for `check` to name.
fn most_corners(primitive: &Primitive<'_>) -> u64 {
    let count = |accessor: Option<Accessor<'_>>| {
        accessor.map(|accessor| (accessor.count() as u64).min(3 * MAX_TRIANGLES))
    };
    let vertices = count(primitive.get(&Semantic::Positions)).unwrap_or(0);
    let given = count(primitive.indices()).unwrap_or(vertices);
    // Each corner of a strip or fan but two makes a triangle.
    let corners = if primitive.mode() == Mode::Triangles { given } else { 3 * given };
    vertices.max(corners)
}

/// The crate's own validation of indices, after the one check whose lack makes it panic.
fn validate(document: Document) -> Result<Document, ImportError> {
    let json = document.into_json();
    for (m, mesh) in json.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let position = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            if position.is_some_and(|index| index.value() >= json.accessors.len()) {
                let place = format!("mesh {m} primitive {p}");
                return Err(ImportError::invalid(place, "POSITION names no accessor"));
            }
        }
    }
    Document::from_json(json).map_err(file_error)
}

fn file_error(error: gltf::Error) -> ImportError {
    ImportError::invalid("file", error.to_string())
}

fn read_buffers(
    document: &Document,
    mut blob: Option<Vec<u8>>,
    folder: &Path,
) -> Result<Vec<Vec<u8>>, ImportError> {
    document
        .buffers()
        .map(|buffer| {
            let place = format!("buffer {}", buffer.index());
            let bytes = match buffer.source() {
                Source::Bin => blob
                    .take()
                    .ok_or_else(|| ImportError::invalid(&place, "the file has no BIN chunk"))?,
                Source::Uri(uri) => read_uri(uri, folder, &place)?,
            };
            if bytes.len() < buffer.length() {
                let problem = format!("{} bytes, not {}", bytes.len(), buffer.length());
                return Err(ImportError::invalid(place, problem));
            }
            Ok(bytes)
        })
        .collect()
}

/// The bytes of a base64 data URI, or of a file in `folder` or below it.
fn read_uri(uri: &str, folder: &Path, place: &str) -> Result<Vec<u8>, ImportError> {
    let invalid = |problem: String| ImportError::invalid(place, problem);
    let shown: String = uri.chars().take(80).collect();
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, encoded)) = data.split_once(";base64,") else {
            return Err(invalid("a data URI that is not base64".into()));
        };
        return base64::engine::general_purpose::STANDARD
            .decode(encoded)
            .map_err(|error| invalid(format!("its base64 is wrong: {error}")));
    }
    let path = percent_decode(uri).ok_or_else(|| invalid(format!("bad URI `{shown}`")))?;
    let inside = Path::new(&path).components().all(|part| matches!(part, Component::Normal(_)));
    // A colon is a scheme (http:) or a drive, a backslash a separator elsewhere.
    if !inside || path.is_empty() || path.contains([':', '\\']) {
        return Err(invalid(format!("the URI `{shown}` is no path inside the scene's folder")));
    }
    let io_error = |source| ImportError::Io { what: format!("{place} (`{shown}`)"), source };
    let folder = folder.canonicalize().map_err(io_error)?;
    // Links are followed here, so that one that leads out shows.
    let target = folder.join(&path).canonicalize().map_err(io_error)?;
    if !target.starts_with(&folder) {
        return Err(invalid(format!("the URI `{shown}` leads out of the scene's folder")));
    }
    read_file(&target, place)
}

fn percent_decode(uri: &str) -> Option<String> {
    let mut decoded = Vec::with_capacity(uri.len());
    let mut bytes = uri.bytes();
    while let Some(byte) = bytes.next() {
        decoded.push(if byte == b'%' {
            let mut digit = || char::from(bytes.next()?).to_digit(16);
            (digit()? * 16 + digit()?) as u8
        } else {
            byte
        });
    }
    String::from_utf8(decoded).ok().filter(|path| !path.contains('\0'))
}

fn push_primitive(
    mesh: &mut Mesh,
    what: &str,
    primitive: &Primitive<'_>,
    buffers: &[Vec<u8>],
    transform: Mat4,
) -> Result<(), ImportError> {
    use DataType::{F32, U8, U16, U32};
    use Dimensions::{Scalar, Vec3 as V3, Vec4 as V4};

    let Some(accessor) = primitive.get(&Semantic::Positions) else {
        return Err(ImportError::invalid(what, "no POSITION"));
    };
    let count = accessor.count();
    let positions_place = check(&accessor, buffers, &[F32], &[V3])?;
    let optional = |semantic: Semantic, types: &[DataType], dimensions: &[Dimensions]| {
        let Some(accessor) = primitive.get(&semantic) else { return Ok(None) };
        let place = check(&accessor, buffers, types, dimensions)?;
        if accessor.count() != count {
            let problem = format!("{} elements, not {count} as POSITION", accessor.count());
            return Err(ImportError::invalid(place, problem));
        }
        Ok(Some(place))
    };
    let normals_place = optional(Semantic::Normals, &[F32], &[V3])?;
    optional(Semantic::Colors(0), &[F32, U8, U16], &[V3, V4])?;
    let indices_place = match primitive.indices() {
        Some(accessor) => check(&accessor, buffers, &[U8, U16, U32], &[Scalar])?,
        None => what.to_owned(),
    };

    // From here on the readers only meet accessors that lie in their buffers.
    let missing = |place: &str| ImportError::invalid(place, "its data cannot be read");
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
    let positions = reader.read_positions().ok_or_else(|| missing(&positions_place))?;
    let positions: Vec<[f32; 3]> = positions
        .enumerate()
        .map(|(i, position)| {
            let position = transform.transform_point3(position.into());
            let finite = position.is_finite().then_some(position.to_array());
            finite.ok_or_else(|| {
                let problem = format!("element {i} is not finite where its node puts it");
                ImportError::invalid(&positions_place, problem)
            })
        })
        .collect::<Result<_, _>>()?;

    let normals = match (reader.read_normals(), normals_place) {
        (Some(normals), Some(place)) => {
            // The cofactor matrix turns normals rightly under uneven scale, and needs no inverse.
            let m = Mat3::from_mat4(transform);
            let cofactors = Mat3::from_cols(
                m.y_axis.cross(m.z_axis),
                m.z_axis.cross(m.x_axis),
                m.x_axis.cross(m.y_axis),
            );
            let turned = normals.enumerate().map(|(i, normal)| {
                unit_normal((cofactors * Vec3::from(normal)).to_array()).ok_or_else(|| {
                    ImportError::invalid(&place, format!("element {i} is not finite"))
                })
            });
            Some(turned.collect::<Result<Vec<_>, _>>()?)
        }
        _ => None,
    };

    let base = primitive.material().pbr_metallic_roughness().base_color_factor();
    let rgba: Vec<[u8; 4]> = match reader.read_colors(0) {
        Some(colours) => colours.into_rgba_f32().map(|rgba| blend(rgba, base)).collect(),
        None => vec![blend([1.0; 4], base); count],
    };

    let corners: Vec<u32> = match reader.read_indices() {
        Some(indices) => indices.into_u32().collect(),
        // `check` holds the count of a real accessor below u32::MAX.
        None => (0..count as u32).collect(),
    };
    if let Some((i, index)) =
        corners.iter().enumerate().find(|(_, index)| **index as usize >= count)
    {
        let problem = format!("element {i} is vertex {index}, of {count}");
        return Err(ImportError::invalid(indices_place, problem));
    }
    let indices = triangles(primitive.mode(), &corners)
        .map_err(|problem| ImportError::invalid(what, problem))?;
    push_part(mesh, what, &positions, normals.as_deref(), &rgba, &indices)
}

/// The product of two linear colours, as bytes.
fn blend(rgba: [f32; 4], factor: [f32; 4]) -> [u8; 4] {
    std::array::from_fn(|i| to_byte(rgba[i] * factor[i]))
}

/// Corners of separate triangles.
fn triangles(mode: Mode, corners: &[u32]) -> Result<Vec<u32>, String> {
    match mode {
        Mode::Triangles if corners.len().is_multiple_of(3) => Ok(corners.to_vec()),
        Mode::Triangles => Err(format!("{} corners do not make triangles", corners.len())),
        Mode::TriangleStrip => Ok(corners
            .windows(3)
            .enumerate()
            .flat_map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
            .collect()),
        Mode::TriangleFan => {
            let (hub, rim) = corners.split_first().unwrap_or((&0, &[]));
            Ok(rim.windows(2).flat_map(|w| [*hub, w[0], w[1]]).collect())
        }
        mode => Err(format!("unsupported mode {mode:?}: only triangles can be drawn")),
    }
}

/// Makes sure that an accessor has one of the types and lies inside its view and buffer. Returns
/// its name for messages.
fn check(
    accessor: &Accessor<'_>,
    buffers: &[Vec<u8>],
    types: &[DataType],
    dimensions: &[Dimensions],
) -> Result<String, ImportError> {
    let place = format!("accessor {}", accessor.index());
    let fail = |problem: String| Err(ImportError::invalid(&place, problem));
    if accessor.sparse().is_some() {
        return fail("sparse accessors are not supported".into());
    }
    let Some(view) = accessor.view() else { return fail("no buffer view".into()) };
    if !types.contains(&accessor.data_type()) || !dimensions.contains(&accessor.dimensions()) {
        let (data_type, dimensions) = (accessor.data_type(), accessor.dimensions());
        return fail(format!("{dimensions:?} of {data_type:?} cannot be used here"));
    }
    let (count, size) = (accessor.count(), accessor.size());
    if count == 0 || count as u64 > 3 * MAX_TRIANGLES {
        return fail(format!("its count is {count}"));
    }
    let stride = view.stride().unwrap_or(size);
    if stride < size {
        return fail(format!("a stride of {stride} bytes for elements of {size}"));
    }
    let buffer = buffers.get(view.buffer().index()).map_or(0, Vec::len);
    if view.offset().checked_add(view.length()).is_none_or(|end| end > buffer) {
        return fail(format!(
            "buffer view {} is outside its buffer of {buffer} bytes",
            view.index()
        ));
    }
    let end = (count - 1)
        .checked_mul(stride)
        .and_then(|last| last.checked_add(size)?.checked_add(accessor.offset()));
    if end.is_none_or(|end| end > view.length()) {
        let length = view.length();
        return fail(format!("{count} elements do not fit into its view of {length} bytes"));
    }
    Ok(place)
}
