//! A technique's coordinate, taken apart.

/// A technique's coordinate and its parts.
///
/// The parts are empty strings where the coordinate is not of the form
/// `capture/schedule/sort/stage/max[/ties-RULE][/poolN]`, as for methods that have no sort.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub struct Technique {
    /// The whole coordinate.
    pub coordinate: String,
    /// The capture method: `linked_list`, `linearized`.
    pub capture: String,
    /// The schedule: `base`, `bma-stencil`, `bma-list`.
    pub schedule: String,
    /// The sort strategy; strategies of several intervals are joined by `+`.
    pub sort: String,
    /// Where the resolve runs: `fragment` or `compute`. Called so because *stage* also names a
    /// timed part of a frame.
    pub shader_stage: String,
    /// The most fragments sorted a pixel: `peak` or `maxN`.
    pub max: String,
    /// The tie rule: `total` (depth, then colour) or `depth`.
    pub ties: String,
    /// Room in the pool at first, in percent of what is needed: `100` unless said otherwise.
    pub pool_percent: String,
}

impl Technique {
    /// Takes a coordinate apart.
    #[must_use]
    pub fn parse(coordinate: &str) -> Self {
        let whole = Self { coordinate: coordinate.to_owned(), ..Self::default() };
        let parts: Vec<&str> = coordinate.split('/').collect();
        let [capture, schedule, sort, shader_stage, max, options @ ..] = parts.as_slice() else {
            return whole;
        };
        let (mut ties, mut pool_percent) = ("total", "100");
        for option in options {
            if let Some(rule) = option.strip_prefix("ties-") {
                ties = rule;
            } else if let Some(percent) = option.strip_prefix("pool") {
                pool_percent = percent;
            } else {
                return whole;
            }
        }
        Self {
            capture: (*capture).to_owned(),
            schedule: (*schedule).to_owned(),
            sort: (*sort).to_owned(),
            shader_stage: (*shader_stage).to_owned(),
            max: (*max).to_owned(),
            ties: ties.to_owned(),
            pool_percent: pool_percent.to_owned(),
            ..whole
        }
    }

    /// Whether fragments beyond a fixed number a pixel are dropped, so that the picture may differ.
    #[must_use]
    pub fn truncated(&self) -> bool {
        self.max.starts_with("max")
    }
}

/// A scene's name without its overridden parameters: `grid` of `grid{layers=20}`.
#[must_use]
pub fn scene_name(scene: &str) -> &str {
    scene.split('{').next().unwrap_or(scene)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coordinate_comes_apart() {
        let technique =
            Technique::parse("linearized/bma-list/network+rbs/compute/max32/ties-depth");
        assert_eq!(technique.capture, "linearized");
        assert_eq!(technique.schedule, "bma-list");
        assert_eq!(technique.sort, "network+rbs");
        assert_eq!(technique.shader_stage, "compute");
        assert!(technique.truncated());
        assert_eq!(technique.ties, "depth");
        let technique = Technique::parse("linked_list/base/insertion/fragment/peak");
        assert!(!technique.truncated());
        assert_eq!((technique.ties.as_str(), technique.pool_percent.as_str()), ("total", "100"));
        assert_eq!(Technique::parse("a/b/c/d/e/ties-depth/pool50").pool_percent, "50");
    }

    #[test]
    fn other_methods_keep_their_coordinate() {
        let technique = Technique::parse("depth-peel/peak");
        assert_eq!(technique.coordinate, "depth-peel/peak");
        assert_eq!(technique.sort, "");
        // An option that is not known makes it another kind of coordinate.
        assert_eq!(Technique::parse("a/b/c/d/e/f").capture, "");
    }

    #[test]
    fn a_scene_has_a_name() {
        assert_eq!(scene_name("grid{layers=20}"), "grid");
        assert_eq!(scene_name("planes"), "planes");
    }
}
