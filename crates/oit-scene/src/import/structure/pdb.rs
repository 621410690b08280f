//! PDB files: wwPDB, Atomic Coordinate Entry Format Description, version 3.3, chapters 8 and 9.

use super::element::Element;
use super::{Structure, coordinate};
use crate::ImportError;

/// A field and its first and last column, counted from 1.
#[derive(Debug, Clone, Copy)]
struct Field(&'static str, usize, usize);

const NAME: Field = Field("name", 13, 16);
const ALTERNATE: Field = Field("altLoc", 17, 17);
const CHAIN: Field = Field("chainID", 22, 22);
/// The chain, the number within it and the insertion code.
const RESIDUE: Field = Field("resSeq", 22, 27);
const COORDINATES: [Field; 3] = [Field("x", 31, 38), Field("y", 39, 46), Field("z", 47, 54)];
const ELEMENT: Field = Field("element", 77, 78);

/// Reads the `ATOM` and `HETATM` records of the first model.
pub(super) fn read(bytes: &[u8], structure: &mut Structure) -> Result<(), ImportError> {
    for (line_number, line) in (1..).zip(bytes.split(|byte| *byte == b'\n')) {
        let line = Line { number: line_number, bytes: line.trim_ascii_end() };
        match line.bytes.get(..6).unwrap_or(line.bytes).trim_ascii_end() {
            b"ATOM" | b"HETATM" => atom(&line, structure)?,
            // What follows belongs to another model, or to nothing.
            b"ENDMDL" | b"END" => break,
            _ => {}
        }
    }
    Ok(())
}

fn atom(line: &Line<'_>, structure: &mut Structure) -> Result<(), ImportError> {
    let mut center = [0.0; 3];
    for (value, field) in center.iter_mut().zip(COORDINATES) {
        *value = coordinate(line.needed(field)?).map_err(|problem| line.wrong(field, problem))?;
    }
    let element = match line.text(ELEMENT)? {
        // Files of before 1996 have something else there, or nothing.
        "" => line.element_of_name()?,
        symbol => Element::parse(symbol)
            .ok_or_else(|| line.wrong(ELEMENT, format!("unknown element `{symbol}`")))?,
    };
    let alternate = line.text(ALTERNATE)?;
    if !alternate.is_empty() && !structure.keeps(line.text(RESIDUE)?, alternate) {
        return Ok(());
    }
    structure.push(center, element, line.text(CHAIN)?)
}

/// A line without the blanks at its end.
struct Line<'a> {
    number: u64,
    bytes: &'a [u8],
}

impl<'a> Line<'a> {
    /// A field without blanks about it; empty where the line ends before it.
    fn text(&self, field: Field) -> Result<&'a str, ImportError> {
        let Field(_, first, last) = field;
        let end = last.min(self.bytes.len());
        let bytes = self.bytes.get(first - 1..end).unwrap_or_default().trim_ascii();
        if !bytes.is_ascii() {
            return Err(self.wrong(field, "not ASCII"));
        }
        std::str::from_utf8(bytes).map_err(|_| self.wrong(field, "not ASCII"))
    }

    /// A field that must be there as a whole.
    fn needed(&self, field: Field) -> Result<&'a str, ImportError> {
        let Field(_, _, last) = field;
        if self.bytes.len() < last {
            return Err(self.wrong(field, "the line ends before it does"));
        }
        match self.text(field)? {
            "" => Err(self.wrong(field, "is blank")),
            text => Ok(text),
        }
    }

    fn wrong(&self, Field(name, first, last): Field, problem: impl Into<String>) -> ImportError {
        let place = format!("line {}, field `{name}` (columns {first} to {last})", self.number);
        ImportError::invalid(place, problem)
    }

    /// The element that an atom's name begins with: its symbol ends in the field's second column.
    /// A name of four letters that begins with H is a hydrogen's, not mercury's or holmium's.
    fn element_of_name(&self) -> Result<Element, ImportError> {
        self.text(NAME)?;
        let raw = self.bytes.get(12..16).unwrap_or_default();
        let name = std::str::from_utf8(raw).unwrap_or_default();
        let symbol = match name.as_bytes() {
            [b'H' | b'h', _, _, last] if *last != b' ' => &name[..1],
            // A digit or a blank before a symbol of one letter.
            [first, second, ..] if !first.is_ascii_alphabetic() && second.is_ascii_alphabetic() => {
                &name[1..2]
            }
            _ => name.get(..2).unwrap_or_default().trim_ascii_end(),
        };
        Element::parse(symbol)
            .or_else(|| Element::parse(symbol.get(..1)?))
            .ok_or_else(|| self.wrong(NAME, format!("no element in `{}`", name.trim())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: &str = "\
HEADER    TEST
MODEL        1
ATOM      1  N   ALA A   1      11.104   6.134  -6.504  1.00  0.00           N
ATOM      2  CA AALA A   1      11.639   6.071  -5.147  0.60  0.00           C
ATOM      3  CA BALA A   1      11.700   6.100  -5.100  0.40  0.00           C
HETATM    4 CA    CA B   2       1.000   2.000   3.000  1.00  0.00          CA
ENDMDL
MODEL        2
ATOM      1  N   ALA C   1       0.000   0.000   0.000  1.00  0.00           N
ENDMDL
END
";

    fn structure(text: &[u8]) -> Result<Structure, String> {
        let mut structure = Structure::new(10);
        read(text, &mut structure).map_err(|error| error.to_string())?;
        Ok(structure)
    }

    #[test]
    fn the_first_model_and_the_first_alternate() {
        for text in [TWO.to_owned(), TWO.replace('\n', "\r\n")] {
            let read = structure(text.as_bytes()).unwrap();
            let atoms: Vec<_> = read.atoms.iter().map(|a| (a.center, a.element, a.chain)).collect();
            let element = |symbol| Element::parse(symbol).unwrap();
            assert_eq!(
                atoms,
                [
                    ([11.104, 6.134, -6.504], element("N"), 0),
                    ([11.639, 6.071, -5.147], element("C"), 0),
                    ([1.0, 2.0, 3.0], element("Ca"), 1),
                ]
            );
            assert_eq!(read.chains, ["A", "B"]);
        }
    }

    #[test]
    fn the_name_tells_the_element_where_no_field_does() {
        for (name, symbol) in [
            (" CA ", "C"),
            ("CA  ", "Ca"),
            (" N  ", "N"),
            ("1HB ", "H"),
            ("HG11", "H"),
            ("HG  ", "Hg"),
            ("FE  ", "Fe"),
            (" OXT", "O"),
            (" NH1", "N"),
            ("ZN  ", "Zn"),
            (" H  ", "H"),
            ("C   ", "C"),
        ] {
            let text = format!("ATOM      1 {name} ALA A   1      11.104   6.134  -6.504");
            let read = structure(text.as_bytes()).unwrap();
            assert_eq!(read.atoms[0].element, Element::parse(symbol).unwrap(), "{name}");
        }
    }

    #[test]
    fn mistakes_have_a_line_and_a_field() {
        let replaced = |old: &str, new: &str| {
            assert!(TWO.contains(old), "{old}");
            structure(TWO.replacen(old, new, 1).as_bytes()).unwrap_err()
        };
        for (old, new, message) in [
            (
                "  11.104",
                "  11.1o4",
                "line 3, field `x` (columns 31 to 38): `11.1o4` is not a number",
            ),
            ("   6.071", "        ", "line 4, field `y` (columns 39 to 46): is blank"),
            ("  -6.504", "     nan", "line 3, field `z` (columns 47 to 54): must be from "),
            ("  -6.504", "     inf", "line 3, field `z` (columns 47 to 54): must be from "),
            ("  -6.504", " 1e+0300", "line 3, field `z` (columns 47 to 54): must be from "),
            (
                "          CA\n",
                "          Qq\n",
                "line 6, field `element` (columns 77 to 78): unknown element `Qq`",
            ),
            (
                "   3.000  1.00  0.00          CA",
                " 3.0",
                "line 6, field `z` (columns 47 to 54): the line ends",
            ),
            ("  11.104", " ɑ1.10", "line 3, field `x` (columns 31 to 38): not ASCII"),
        ] {
            let error = replaced(old, new);
            assert!(error.starts_with(message), "{error}");
        }
        let nameless = "ATOM      1  ?   ALA A   1      11.104   6.134  -6.504";
        assert_eq!(
            structure(nameless.as_bytes()).unwrap_err(),
            "line 1, field `name` (columns 13 to 16): no element in `?`"
        );
    }

    #[test]
    fn too_many_atoms_are_refused() {
        let line = "ATOM      1  N   ALA A   1      11.104   6.134  -6.504\n";
        assert_eq!(structure(line.repeat(10).as_bytes()).unwrap().atoms.len(), 10);
        assert_eq!(structure(line.repeat(11).as_bytes()).unwrap_err(), "more than 10 atoms");
    }
}
