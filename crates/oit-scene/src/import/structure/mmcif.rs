//! mmCIF files: the loop of the category `_atom_site`. Syntax: Hall and McMahon, International Tables
//! for Crystallography G (2005), chapter 2.2; items: the dictionary PDBx/mmCIF.

use super::element::Element;
use super::{Structure, coordinate};
use crate::ImportError;

const CATEGORY: &str = "_atom_site.";

/// The dictionary has about a hundred items of the category.
const MAX_TAGS: usize = 1024;

/// Reads the atoms of the first model of the first `_atom_site` loop.
pub(super) fn read(bytes: &[u8], structure: &mut Structure) -> Result<(), ImportError> {
    let mut tokens = Tokens { bytes, at: 0, line: 1 };
    let mut token = tokens.next_token()?;
    while let Some(current) = token {
        if !current.is_word("loop_") {
            token = tokens.next_token()?;
            continue;
        }
        let mut tags: Vec<&str> = Vec::new();
        token = tokens.next_token()?;
        while let Some(tag) = token.filter(Token::is_tag) {
            // Of another category's loop no more than the first is needed.
            if tags.first().is_none_or(|first| is_of_category(first)) {
                tags.push(tag.text);
            }
            if tags.len() > MAX_TAGS {
                let place = format!("line {}, field `{}`", tag.line, tag.text);
                return Err(ImportError::invalid(place, format!("more than {MAX_TAGS} fields")));
            }
            token = tokens.next_token()?;
        }
        if tags.first().is_some_and(|first| is_of_category(first)) {
            return rows(&Columns::new(tags, current.line)?, token, &mut tokens, structure);
        }
    }
    Err(ImportError::invalid("file", "no loop of `_atom_site`"))
}

/// The item's name within the category.
fn item(tag: &str) -> Option<&str> {
    let (category, item) = tag.split_at_checked(CATEGORY.len())?;
    category.eq_ignore_ascii_case(CATEGORY).then_some(item)
}

fn is_of_category(tag: &str) -> bool {
    item(tag).is_some()
}

fn rows(
    columns: &Columns<'_>,
    first: Option<Token<'_>>,
    tokens: &mut Tokens<'_>,
    structure: &mut Structure,
) -> Result<(), ImportError> {
    let mut token = first;
    let mut row = Vec::with_capacity(columns.tags.len());
    // Its number, as text.
    let mut first_model: Option<String> = None;
    while let Some(value) = token.filter(|token| !token.ends_loop()) {
        row.push(value);
        if row.len() == columns.tags.len() {
            atom(columns, &row, &mut first_model, structure)?;
            row.clear();
        }
        token = tokens.next_token()?;
    }
    match row.first() {
        None => Ok(()),
        Some(start) => {
            let place = format!("line {}, field `{}`", tokens.line, columns.tags[row.len()]);
            let problem =
                format!("the loop ends within the row that begins in line {}", start.line);
            Err(ImportError::invalid(place, problem))
        }
    }
}

fn atom(
    columns: &Columns<'_>,
    row: &[Token<'_>],
    first_model: &mut Option<String>,
    structure: &mut Structure,
) -> Result<(), ImportError> {
    let text = |column: Option<usize>| column.and_then(|column| row[column].value()).unwrap_or("");
    let wrong = |column: usize, problem: String| {
        let place = format!("line {}, field `{}`", row[column].line, columns.tags[column]);
        ImportError::invalid(place, problem)
    };
    let model = text(columns.model);
    if first_model.get_or_insert_with(|| model.to_owned()) != model {
        return Ok(());
    }
    let mut center = [0.0; 3];
    for (value, column) in center.iter_mut().zip(columns.coordinates) {
        // The standard uncertainty in brackets, `1.25(3)`, is left away.
        let text = row[column].text;
        let text =
            text.strip_suffix(')').and_then(|text| text.split_once('(')).map_or(text, |t| t.0);
        *value = coordinate(text).map_err(|problem| wrong(column, problem))?;
    }
    let symbol = row[columns.element].text;
    let element = Element::parse(symbol)
        .ok_or_else(|| wrong(columns.element, format!("unknown element `{symbol}`")))?;
    let chain = text(columns.chain);
    let alternate = text(columns.alternate);
    if !alternate.is_empty() {
        let residue = columns.residue.map(text);
        let residue = format!("{chain} {}", residue.join(" "));
        if !structure.keeps(&residue, alternate) {
            return Ok(());
        }
    }
    structure.push(center, element, chain)
}

/// Where in a row what is needed stands.
struct Columns<'a> {
    tags: Vec<&'a str>,
    coordinates: [usize; 3],
    element: usize,
    chain: Option<usize>,
    alternate: Option<usize>,
    model: Option<usize>,
    /// Number and insertion code.
    residue: [Option<usize>; 2],
}

impl<'a> Columns<'a> {
    /// `line` is the loop's.
    fn new(tags: Vec<&'a str>, line: u64) -> Result<Self, ImportError> {
        let wrong = |field: &str, problem: &str| {
            ImportError::invalid(format!("line {line}, field `{field}`"), problem)
        };
        let find = |name: &str| {
            let is = |tag: &&str| item(tag).is_some_and(|item| item.eq_ignore_ascii_case(name));
            tags.iter().position(is)
        };
        let need = |name: &str| {
            find(name)
                .ok_or_else(|| wrong(&format!("{CATEGORY}{name}"), "the loop does not have it"))
        };
        if let Some(other) = tags.iter().find(|tag| !is_of_category(tag)) {
            return Err(wrong(other, "not of the category of its loop"));
        }
        Ok(Self {
            coordinates: [need("Cartn_x")?, need("Cartn_y")?, need("Cartn_z")?],
            element: need("type_symbol")?,
            // As authors call them, if they do: so are they in PDB files.
            chain: find("auth_asym_id").or_else(|| find("label_asym_id")),
            alternate: find("label_alt_id"),
            model: find("pdbx_PDB_model_num"),
            residue: [
                find("auth_seq_id").or_else(|| find("label_seq_id")),
                find("pdbx_PDB_ins_code"),
            ],
            tags,
        })
    }
}

/// A word or a value.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Token<'a> {
    text: &'a str,
    /// Of its first character, counted from 1.
    line: u64,
    /// Whether it stood in quotes or between lines of semicolons: then it is a value.
    quoted: bool,
}

impl<'a> Token<'a> {
    fn is_tag(&self) -> bool {
        !self.quoted && self.text.starts_with('_')
    }

    fn is_word(&self, word: &str) -> bool {
        !self.quoted && self.text.eq_ignore_ascii_case(word)
    }

    /// Whether it is something else than a loop's value.
    fn ends_loop(&self) -> bool {
        let starts = |word: &str| {
            !self.quoted
                && self.text.get(..word.len()).is_some_and(|t| t.eq_ignore_ascii_case(word))
        };
        self.is_tag() || starts("data_") || starts("save_") || self.is_word("loop_")
    }

    /// Nothing where the file says that there is none (`.`) or that it is unknown (`?`).
    fn value(&self) -> Option<&'a str> {
        (self.quoted || !matches!(self.text, "." | "?")).then_some(self.text)
    }
}

struct Tokens<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
}

impl<'a> Tokens<'a> {
    fn next_token(&mut self) -> Result<Option<Token<'a>>, ImportError> {
        loop {
            match self.bytes.get(self.at) {
                None => return Ok(None),
                Some(b'\n') => {
                    self.line += 1;
                    self.at += 1;
                }
                Some(b'#') => self.at = self.line_end(),
                Some(byte) if byte.is_ascii_whitespace() => self.at += 1,
                Some(_) => break,
            }
        }
        let rest = &self.bytes[self.at..];
        let at_line_start = self.at == 0 || self.bytes[self.at - 1] == b'\n';
        match rest[0] {
            b';' if at_line_start => {
                let end = rest.windows(2).position(|pair| pair == b"\n;");
                let end = end.ok_or_else(|| self.wrong("a text field does not end"))?;
                self.token(1, end, 2).map(Some)
            }
            quote @ (b'\'' | b'"') => {
                let line = &rest[..self.line_end() - self.at];
                // A quote ends where a blank follows it, or the line's end.
                let closes = |&at: &usize| {
                    line[at] == quote && line.get(at + 1).is_none_or(u8::is_ascii_whitespace)
                };
                let end = (1..line.len()).find(closes);
                let end = end.ok_or_else(|| self.wrong("a quote does not end in its line"))?;
                self.token(1, end, 1).map(Some)
            }
            _ => {
                let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
                self.token(0, end, 0).map(Some)
            }
        }
    }

    /// The token of these bytes, counted from here; so many more belong to it.
    fn token(&mut self, start: usize, end: usize, more: usize) -> Result<Token<'a>, ImportError> {
        let bytes = &self.bytes[self.at + start..self.at + end];
        let text = std::str::from_utf8(bytes).map_err(|_| self.wrong("not UTF-8"))?;
        let token = Token { text, line: self.line, quoted: start > 0 };
        let whole = &self.bytes[self.at..self.at + end + more];
        self.line += whole.iter().filter(|byte| **byte == b'\n').count() as u64;
        self.at += whole.len();
        Ok(token)
    }

    fn line_end(&self) -> usize {
        let end = self.bytes[self.at..].iter().position(|byte| *byte == b'\n');
        end.map_or(self.bytes.len(), |end| self.at + end)
    }

    fn wrong(&self, problem: &str) -> ImportError {
        ImportError::invalid(format!("line {}", self.line), problem)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: &str = "\
data_TEST
_entry.id 'TE'ST'
# loop_
_struct.title
;A title
loop_
;
loop_
_other.id
_other.text
1 'a b' 2 \"_atom_site.c\"
loop_
_atom_site.group_PDB
_atom_site.type_symbol
_atom_site.label_alt_id
_atom_site.auth_asym_id
_atom_site.auth_seq_id
_atom_site.Cartn_x
_atom_site.Cartn_y
_atom_site.Cartn_z
_atom_site.pdbx_PDB_model_num
ATOM N . A 1 11.104 6.134 -6.504 1
ATOM C A A 1 11.639(4) 6.071 -5.147 1
ATOM C B A 1 11.700 6.100 -5.100 1
HETATM CA . 'B' 2
1.000 2.000 3.000 1
ATOM N . C 1 0.000 0.000 0.000 2
#
loop_
_atom_site.nothing
1
";

    fn structure(text: &[u8]) -> Result<Structure, String> {
        let mut structure = Structure::new(10);
        read(text, &mut structure).map_err(|error| error.to_string())?;
        Ok(structure)
    }

    #[test]
    fn the_first_model_and_the_first_alternate() {
        for text in [TWO.to_owned(), TWO.replace('\n', "\r\n"), TWO.to_uppercase()] {
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
    fn columns_that_are_not_there_are_done_without() {
        let text = "loop_ _atom_site.Cartn_z _atom_site.Cartn_y _atom_site.Cartn_x \
                    _atom_site.type_symbol 3 2 1 O 6 5 4 S";
        let read = structure(text.as_bytes()).unwrap();
        assert_eq!(
            read.atoms.iter().map(|a| a.center).collect::<Vec<_>>(),
            [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
        );
        assert_eq!(read.chains, [""]);
    }

    #[test]
    fn mistakes_have_a_line_and_a_field() {
        let replaced = |old: &str, new: &str| {
            assert!(TWO.contains(old), "{old}");
            structure(TWO.replacen(old, new, 1).as_bytes()).unwrap_err()
        };
        for (old, new, message) in [
            ("11.104", "?", "line 22, field `_atom_site.Cartn_x`: `?` is not a number"),
            ("2.000", "nan", "line 26, field `_atom_site.Cartn_y`: must be from "),
            ("2.000", "1e999", "line 26, field `_atom_site.Cartn_y`: must be from "),
            ("CA .", "Qq .", "line 25, field `_atom_site.type_symbol`: unknown element `Qq`"),
            (
                "Cartn_z",
                "Cartn_w",
                "line 12, field `_atom_site.Cartn_z`: the loop does not have it",
            ),
            (
                "site.group_PDB",
                "site.group_PDB\n_x.y",
                "line 12, field `_x.y`: not of the category",
            ),
            (
                " 2\n#",
                "\n#",
                "line 29, field `_atom_site.pdbx_PDB_model_num`: the loop ends within the row that begins in line 27",
            ),
            ("'B'", "'B", "line 25: a quote does not end in its line"),
            ("\n;\n", "\n\n", "line 5: a text field does not end"),
        ] {
            let error = replaced(old, new);
            assert!(error.starts_with(message), "{new}: {error}");
        }
        assert_eq!(structure(b"data_x").unwrap_err(), "file: no loop of `_atom_site`");
        assert_eq!(structure(b"data_x \xff").unwrap_err(), "line 1: not UTF-8");
    }
}
