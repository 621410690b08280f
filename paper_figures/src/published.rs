//! Published numbers. They live only in `published/*.toml`, transcribed from the papers.

use serde::Deserialize;

use crate::FigureError;

/// One table of a paper.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Authors, title, venue, year.
    pub paper: String,
    /// The table's number.
    pub table: String,
    /// Where it stands in the paper.
    pub place: String,
    /// The paper's caption.
    pub caption: String,
    /// The device measured.
    pub device: String,
    /// The resolution, `1920x1080`.
    pub resolution: String,
    /// `ms` or `speedup`.
    pub unit: String,
    /// Scenes and views, or whatever the columns are grouped by.
    pub views: Vec<String>,
    /// The columns of each view.
    pub quantities: Vec<String>,
    /// Rows with one value a view.
    #[serde(default)]
    pub facts: Vec<Row>,
    /// Rows with one value a view and quantity, view by view; NaN where the paper has none.
    pub rows: Vec<Row>,
}

/// One row.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Its head.
    pub name: String,
    /// Its values.
    pub values: Vec<f64>,
}

/// Every published table, by the name of the figure it belongs to.
pub const TABLES: &[(&str, &str)] = &[
    ("rbs-table-1", include_str!("../published/rbs-table-1.toml")),
    ("rbs-table-2", include_str!("../published/rbs-table-2.toml")),
    ("rbs-table-3", include_str!("../published/rbs-table-3.toml")),
    ("bma-table-1", include_str!("../published/bma-table-1.toml")),
    ("bma-table-2", include_str!("../published/bma-table-2.toml")),
    ("lfb-table-20.1", include_str!("../published/lfb-table-20.1.toml")),
    ("spheres-table-3.1", include_str!("../published/spheres-table-3.1.toml")),
    ("spheres-table-3.2", include_str!("../published/spheres-table-3.2.toml")),
    ("spheres-table-3.3", include_str!("../published/spheres-table-3.3.toml")),
    ("spheres-table-3.4", include_str!("../published/spheres-table-3.4.toml")),
    ("spheres-table-3.5", include_str!("../published/spheres-table-3.5.toml")),
    ("spheres-table-4.1", include_str!("../published/spheres-table-4.1.toml")),
];

/// Reads a published table.
///
/// # Errors
/// Where there is none of that name, or the file does not make a table.
pub fn table(name: &'static str) -> Result<Published, FigureError> {
    let Some((_, text)) = TABLES.iter().find(|(known, _)| *known == name) else {
        let known: Vec<&str> = TABLES.iter().map(|(known, _)| *known).collect();
        let (what, name, known) = ("published table", name.to_owned(), known.join(", "));
        return Err(FigureError::Unknown { what, name, known });
    };
    let wrong = |reason: String| FigureError::Data { file: name, reason };
    let table: Published = toml::from_str(text).map_err(|error| wrong(error.to_string()))?;
    let columns = table.views.len() * table.quantities.len();
    let rows = table.rows.iter().map(|row| (row, columns));
    for (row, needed) in rows.chain(table.facts.iter().map(|row| (row, table.views.len()))) {
        let found = row.values.len();
        if found != needed {
            return Err(wrong(format!("{}: {found} values for {needed} columns", row.name)));
        }
    }
    Ok(table)
}

impl Published {
    /// What the paper says of a view as a whole; `None` where it says nothing.
    #[must_use]
    pub fn fact(&self, name: &str, view: &str) -> Option<f64> {
        let row = self.facts.iter().find(|known| known.name == name)?;
        let view = self.views.iter().position(|known| known == view)?;
        row.values.get(view).copied().filter(|value| value.is_finite())
    }

    /// A value of the table; `None` where the paper has none.
    #[must_use]
    pub fn value(&self, row: &str, view: &str, quantity: &str) -> Option<f64> {
        let row = self.rows.iter().find(|known| known.name == row)?;
        let view = self.views.iter().position(|known| known == view)?;
        let quantity = self.quantities.iter().position(|known| known == quantity)?;
        let value = row.values.get(view * self.quantities.len() + quantity)?;
        Some(*value).filter(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_table_is_whole() {
        for (name, _) in TABLES {
            table(name).unwrap();
        }
        assert!(table("rbs-table-9").is_err());
    }

    /// Half of the last digit that Table 2 prints.
    fn rounding(ms: f64, view: &str) -> f64 {
        if view.starts_with("atrium") {
            0.05
        } else if ms > 0.0 {
            0.5
        } else {
            0.0
        }
    }

    /// The speed-ups of Table 3 that cannot come from any times that round to those of Table 2.
    fn speedups_that_do_not_follow() -> Vec<String> {
        let (times, speedups) = (table("rbs-table-2").unwrap(), table("rbs-table-3").unwrap());
        let mut wrong = Vec::new();
        for view in &times.views {
            for quantity in &times.quantities {
                let time = |row: &str| times.value(row, view, quantity);
                let rest = times.rows.iter().filter(|row| !row.name.contains("RBS"));
                let best_of_rest =
                    rest.filter_map(|row| time(&row.name)).fold(f64::INFINITY, f64::min);
                for row in &speedups.rows {
                    let starred = row.name == "BMA-RBS-L*";
                    let published = speedups.value(&row.name, view, quantity);
                    let (base, own) = if starred {
                        (Some(best_of_rest), time("BMA-RBS-L"))
                    } else {
                        (time("BASE-IS"), time(&row.name))
                    };
                    let (Some(published), Some(base), Some(own)) = (published, base, own) else {
                        assert_eq!(published.is_some(), own.is_some());
                        continue;
                    };
                    let half = rounding(own, view);
                    let (low, high) = ((base - half) / (own + half), (base + half) / (own - half));
                    if published < low - 0.05 - 1e-9 || published > high + 0.05 + 1e-9 {
                        wrong.push(format!("{} {view} {quantity}", row.name));
                    }
                }
            }
        }
        wrong
    }

    #[test]
    fn rbs_table_3_follows_from_table_2() {
        assert_eq!(speedups_that_do_not_follow(), Vec::<String>::new());
    }

    #[test]
    fn bma_table_2_divides() {
        let table = table("bma-table-2").unwrap();
        for view in &table.views {
            for quantity in &table.quantities {
                let value = |row| table.value(row, view, quantity).unwrap();
                let ratio = value("OIT (ms)") / value("BMA-OIT (ms)");
                assert!((ratio - value("Speedup")).abs() < 0.01, "{view} {quantity}: {ratio}");
            }
        }
    }

    #[test]
    fn lfb_table_20_1_adds_up_to_its_totals() {
        let table = table("lfb-table-20.1").unwrap();
        for view in &table.views {
            for quantity in &table.quantities {
                let steps = table.rows.iter().filter(|row| row.name != "Total");
                let sum: f64 = steps.filter_map(|row| table.value(&row.name, view, quantity)).sum();
                let off = sum - table.value("Total", view, quantity).unwrap();
                // The paper's own: its atrium columns miss their totals by the difference of
                // 95.05 and 88.08, as if these two were printed in each other's place.
                let expected = match (view.as_str(), quantity.as_str()) {
                    ("Atrium", "L") => 95.05 - 88.08,
                    ("Atrium", "LL") => 88.08 - 95.05,
                    _ => 0.0,
                };
                assert!((off - expected).abs() < 0.07, "{view} {quantity}: {sum}, off by {off}");
            }
        }
    }
}
