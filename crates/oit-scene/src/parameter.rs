use std::collections::BTreeMap;

use crate::Problem;

/// One documented parameter of a generator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// The key in a scene file.
    pub name: &'static str,
    /// One sentence, with the unit.
    pub about: &'static str,
    /// Type, default and range.
    pub kind: Kind,
}

/// Type, default and inclusive range of a [`Parameter`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(missing_docs, reason = "default, min, max and valid say what they are")]
pub enum Kind {
    /// A whole number.
    Integer { default: u64, min: u64, max: u64 },
    /// A finite number.
    Number { default: f64, min: f64, max: f64 },
    /// One of a few words.
    Word { default: &'static str, valid: &'static [&'static str] },
}

impl Parameter {
    /// A whole number from `min` to `max`.
    pub const fn integer(
        name: &'static str,
        about: &'static str,
        default: u64,
        min: u64,
        max: u64,
    ) -> Self {
        Self { name, about, kind: Kind::Integer { default, min, max } }
    }

    /// A number from `min` to `max`.
    pub const fn number(
        name: &'static str,
        about: &'static str,
        default: f64,
        min: f64,
        max: f64,
    ) -> Self {
        Self { name, about, kind: Kind::Number { default, min, max } }
    }

    /// One of the `valid` words.
    pub const fn word(
        name: &'static str,
        about: &'static str,
        default: &'static str,
        valid: &'static [&'static str],
    ) -> Self {
        Self { name, about, kind: Kind::Word { default, valid } }
    }
}

/// Values for every parameter of one generator, all of the right type and in range.
#[derive(Debug, Clone, PartialEq)]
pub struct Params {
    declared: &'static [Parameter],
    values: BTreeMap<&'static str, Value>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Value {
    Integer(u64),
    Number(f64),
    Word(&'static str),
}

impl Params {
    /// The defaults.
    pub fn new(declared: &'static [Parameter]) -> Self {
        let values = declared.iter().map(|parameter| {
            let value = match parameter.kind {
                Kind::Integer { default, .. } => Value::Integer(default),
                Kind::Number { default, .. } => Value::Number(default),
                Kind::Word { default, .. } => Value::Word(default),
            };
            (parameter.name, value)
        });
        Self { declared, values: values.collect() }
    }

    /// Replaces one value.
    ///
    /// # Errors
    /// [`Problem::Unknown`] for a name that is not declared or a word that is not valid,
    /// [`Problem::Invalid`] for a wrong type or a value out of range.
    pub fn set(&mut self, name: &str, value: &toml::Value) -> Result<(), Problem> {
        let Some(parameter) = self.declared.iter().find(|parameter| parameter.name == name) else {
            let names = self.declared.iter().map(|parameter| parameter.name);
            return Err(Problem::unknown("parameter", name, names));
        };
        let wrong_type = |expected: &str| {
            let found = value.type_str();
            Problem::Invalid(format!("parameter `{name}` must be {expected}, found: {found}"))
        };
        let value = match parameter.kind {
            Kind::Integer { min, max, .. } => {
                let given = value.as_integer().ok_or_else(|| wrong_type("a whole number"))?;
                let inside = u64::try_from(given).ok().filter(|given| (min..=max).contains(given));
                Value::Integer(inside.ok_or_else(|| out_of_range(name, given, min, max))?)
            }
            Kind::Number { min, max, .. } => {
                let given = match value {
                    toml::Value::Float(given) => *given,
                    toml::Value::Integer(given) => *given as f64,
                    _ => return Err(wrong_type("a number")),
                };
                if !(min..=max).contains(&given) {
                    return Err(out_of_range(name, given, min, max));
                }
                Value::Number(given)
            }
            Kind::Word { valid, .. } => {
                let given = value.as_str().ok_or_else(|| wrong_type("a word"))?;
                let word = valid.iter().find(|word| **word == given);
                Value::Word(
                    word.ok_or_else(|| Problem::unknown("word", given, valid.iter().copied()))?,
                )
            }
        };
        self.values.insert(parameter.name, value);
        Ok(())
    }

    /// A whole number.
    ///
    /// # Panics
    /// When the generator did not declare an integer of that name: a mistake in its source, which
    /// the test of all generators finds. The same holds for the other two.
    pub fn integer(&self, name: &str) -> u64 {
        match self.values.get(name) {
            Some(Value::Integer(value)) => *value,
            other => panic!("`{name}` is not a declared integer: {other:?}"),
        }
    }

    /// A number.
    ///
    /// # Panics
    /// When the generator did not declare a number of that name.
    pub fn number(&self, name: &str) -> f32 {
        match self.values.get(name) {
            Some(Value::Number(value)) => *value as f32,
            other => panic!("`{name}` is not a declared number: {other:?}"),
        }
    }

    /// A word.
    ///
    /// # Panics
    /// When the generator did not declare a word of that name.
    pub fn word(&self, name: &str) -> &'static str {
        match self.values.get(name) {
            Some(Value::Word(value)) => value,
            other => panic!("`{name}` is not a declared word: {other:?}"),
        }
    }
}

fn out_of_range<T: std::fmt::Display, U: std::fmt::Display>(
    name: &str,
    given: T,
    min: U,
    max: U,
) -> Problem {
    Problem::Invalid(format!("parameter `{name}` must be from {min} to {max}, not {given}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DECLARED: &[Parameter] = &[
        Parameter::integer("layers", "How many.", 10, 1, 100),
        Parameter::number("gap", "Distance.", 0.5, 0.0, 2.0),
        Parameter::word("order", "Which way.", "up", &["up", "down"]),
    ];

    #[test]
    fn sets_and_refuses() {
        let mut params = Params::new(DECLARED);
        assert_eq!((params.integer("layers"), params.number("gap")), (10, 0.5));
        params.set("layers", &100.into()).unwrap();
        params.set("gap", &1.into()).unwrap();
        params.set("order", &"down".into()).unwrap();
        assert_eq!((params.integer("layers"), params.number("gap")), (100, 1.0));
        assert_eq!(params.word("order"), "down");

        let refused: [(&str, toml::Value, &str); 8] = [
            ("layer", 1.into(), "unknown parameter `layer`, the nearest valid: `layers`"),
            ("layers", 0.into(), "parameter `layers` must be from 1 to 100, not 0"),
            ("layers", (-1).into(), "parameter `layers` must be from 1 to 100, not -1"),
            ("layers", 1.5.into(), "parameter `layers` must be a whole number, found: float"),
            ("gap", "x".into(), "parameter `gap` must be a number, found: string"),
            ("gap", f64::NAN.into(), "parameter `gap` must be from 0 to 2, not NaN"),
            ("order", "dwn".into(), "unknown word `dwn`, the nearest valid: `down`"),
            ("order", 1.into(), "parameter `order` must be a word, found: integer"),
        ];
        let before = params.clone();
        for (name, value, message) in refused {
            assert_eq!(params.set(name, &value).unwrap_err().to_string(), message);
        }
        assert_eq!(params, before);
    }
}
