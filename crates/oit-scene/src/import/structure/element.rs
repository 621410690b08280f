//! Elements: van der Waals radii and colours.

use std::sync::LazyLock;

/// Every element's symbol, by atomic number.
const SYMBOLS: [&str; 118] = [
    "H", "He", "Li", "Be", "B", "C", "N", "O", "F", "Ne", "Na", "Mg", "Al", "Si", "P", "S", "Cl",
    "Ar", "K", "Ca", "Sc", "Ti", "V", "Cr", "Mn", "Fe", "Co", "Ni", "Cu", "Zn", "Ga", "Ge", "As",
    "Se", "Br", "Kr", "Rb", "Sr", "Y", "Zr", "Nb", "Mo", "Tc", "Ru", "Rh", "Pd", "Ag", "Cd", "In",
    "Sn", "Sb", "Te", "I", "Xe", "Cs", "Ba", "La", "Ce", "Pr", "Nd", "Pm", "Sm", "Eu", "Gd", "Tb",
    "Dy", "Ho", "Er", "Tm", "Yb", "Lu", "Hf", "Ta", "W", "Re", "Os", "Ir", "Pt", "Au", "Hg", "Tl",
    "Pb", "Bi", "Po", "At", "Rn", "Fr", "Ra", "Ac", "Th", "Pa", "U", "Np", "Pu", "Am", "Cm", "Bk",
    "Cf", "Es", "Fm", "Md", "No", "Lr", "Rf", "Db", "Sg", "Bh", "Hs", "Mt", "Ds", "Rg", "Cn", "Nh",
    "Fl", "Mc", "Lv", "Ts", "Og",
];

/// Van der Waals radii in ångström: the main group from Mantina et al., Consistent van der Waals Radii
/// for the Whole Main Group, J. Phys. Chem. A 113 (2009), Table 12; metals that it leaves out from
/// Bondi, van der Waals Volumes and Radii, J. Phys. Chem. 68 (1964).
const RADII: [(&str, f32); 54] = [
    ("H", 1.10),
    ("He", 1.40),
    ("Li", 1.81),
    ("Be", 1.53),
    ("B", 1.92),
    ("C", 1.70),
    ("N", 1.55),
    ("O", 1.52),
    ("F", 1.47),
    ("Ne", 1.54),
    ("Na", 2.27),
    ("Mg", 1.73),
    ("Al", 1.84),
    ("Si", 2.10),
    ("P", 1.80),
    ("S", 1.80),
    ("Cl", 1.75),
    ("Ar", 1.88),
    ("K", 2.75),
    ("Ca", 2.31),
    ("Ga", 1.87),
    ("Ge", 2.11),
    ("As", 1.85),
    ("Se", 1.90),
    ("Br", 1.83),
    ("Kr", 2.02),
    ("Rb", 3.03),
    ("Sr", 2.49),
    ("In", 1.93),
    ("Sn", 2.17),
    ("Sb", 2.06),
    ("Te", 2.06),
    ("I", 1.98),
    ("Xe", 2.16),
    ("Cs", 3.43),
    ("Ba", 2.68),
    ("Tl", 1.96),
    ("Pb", 2.02),
    ("Bi", 2.07),
    ("Po", 1.97),
    ("At", 2.02),
    ("Rn", 2.20),
    ("Fr", 3.48),
    ("Ra", 2.83),
    ("Ni", 1.63),
    ("Cu", 1.40),
    ("Zn", 1.39),
    ("Pd", 1.63),
    ("Ag", 1.72),
    ("Cd", 1.58),
    ("Pt", 1.75),
    ("Au", 1.66),
    ("Hg", 1.55),
    ("U", 1.86),
];

/// Of elements without a published radius, ångström.
const OTHER_RADIUS: f32 = 2.0;

/// The colours of Corey, Pauling and Koltun's models as molecular viewers have them, linear values.
const COLORS: [(&[&str], [u8; 3]); 16] = [
    (&["H"], [255, 255, 255]),
    (&["C"], [71, 71, 71]),
    (&["N"], [8, 20, 239]),
    (&["O"], [255, 1, 1]),
    (&["F"], [71, 190, 20]),
    (&["Cl"], [3, 222, 3]),
    (&["Br"], [97, 6, 6]),
    (&["I"], [76, 0, 76]),
    (&["He", "Ne", "Ar", "Kr", "Xe", "Rn"], [115, 196, 233]),
    (&["P"], [255, 55, 0]),
    (&["S"], [255, 255, 8]),
    (&["B"], [255, 118, 118]),
    (&["Li", "Na", "K", "Rb", "Cs", "Fr"], [104, 27, 226]),
    (&["Be", "Mg", "Ca", "Sr", "Ba", "Ra"], [12, 103, 0]),
    (&["Ti"], [133, 138, 146]),
    (&["Fe"], [190, 34, 8]),
];

/// Of all other elements.
const OTHER_COLOR: [u8; 3] = [255, 36, 116];

/// A chemical element: its place in [`SYMBOLS`], or [`UNKNOWN`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Element(u8);

/// What the depositors did not know. Its symbol is X.
const UNKNOWN: u8 = SYMBOLS.len() as u8;

/// Radius and colour by [`Element`].
static LOOKS: LazyLock<Vec<(f32, [u8; 4])>> = LazyLock::new(|| {
    let looks = SYMBOLS.iter().copied().chain(["X"]).map(|symbol| {
        let radius = RADII.iter().find(|(known, _)| *known == symbol);
        let color = COLORS.iter().find(|(known, _)| known.contains(&symbol));
        let [r, g, b] = color.map_or(OTHER_COLOR, |(_, rgb)| *rgb);
        (radius.map_or(OTHER_RADIUS, |(_, radius)| *radius), [r, g, b, 255])
    });
    looks.collect()
});

impl Element {
    /// By its symbol, in letters of any case. Deuterium and tritium are hydrogen.
    pub(super) fn parse(symbol: &str) -> Option<Self> {
        let symbol = match symbol {
            "D" | "d" | "T" | "t" => "H",
            "X" | "x" => return Some(Self(UNKNOWN)),
            _ => symbol,
        };
        let number = SYMBOLS.iter().position(|known| known.eq_ignore_ascii_case(symbol))?;
        Some(Self(number as u8))
    }

    /// Van der Waals radius, ångström.
    pub(super) fn radius(self) -> f32 {
        LOOKS[usize::from(self.0)].0
    }

    /// Opaque, linear values.
    pub(super) fn rgba(self) -> [u8; 4] {
        LOOKS[usize::from(self.0)].1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_of_any_case_have_a_radius_and_a_colour() {
        for symbol in SYMBOLS {
            let element = Element::parse(&symbol.to_uppercase()).unwrap();
            assert_eq!(Some(element), Element::parse(&symbol.to_lowercase()));
            assert!((1.0..4.0).contains(&element.radius()), "{symbol}");
        }
        assert_eq!(Element::parse("d"), Element::parse("H"));
        assert_eq!(Element::parse("Zn").unwrap().radius(), 1.39);
        assert_eq!(Element::parse("Fe").unwrap().radius(), OTHER_RADIUS);
        assert_eq!(Element::parse("N").unwrap().rgba(), [8, 20, 239, 255]);
        assert_eq!(Element::parse("X").unwrap().rgba(), [255, 36, 116, 255]);
        for nonsense in ["", "Q", "Cc", "C1", "é"] {
            assert_eq!(Element::parse(nonsense), None, "{nonsense}");
        }
        for symbol in RADII.iter().map(|(symbol, _)| symbol).chain(COLORS.iter().flat_map(|c| c.0))
        {
            assert!(SYMBOLS.contains(symbol), "{symbol}");
        }
    }
}
