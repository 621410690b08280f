//! A technique's coordinate and a scene's name, taken apart.

use std::collections::BTreeMap;

/// The intervals of the papers.
const POWERS_OF_TWO: &str = "powers-of-two";

/// A technique's coordinate and its parts.
///
/// The parts are empty strings for a way of drawing spheres, and where the coordinate is not of the form
/// `capture/schedule/sort/stage/max[/ties-RULE][/poolN[-drop]][/intervals...]`, as for methods, which have
/// `method` and `method_size` in their place.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub struct Technique {
    /// The whole coordinate.
    pub coordinate: String,
    /// The capture method, which is also the layout: `linked_list`, `linearized`.
    pub capture: String,
    /// The schedule: `base`, `base-stencil`, `bma-stencil`, `bma-list`.
    pub schedule: String,
    /// The sort strategy; strategies of several intervals are joined by `+`.
    pub sort: String,
    /// Where the resolve runs: `fragment`, `compute` or `cuda`. Called so because *stage* also names a
    /// timed part of a frame.
    pub shader_stage: String,
    /// The most fragments sorted a pixel: `peak` or `maxN`.
    pub max: String,
    /// The tie rule: `total` (depth, then colour) or `depth`.
    pub ties: String,
    /// Room in the pool at first, in percent of what is needed: `100` unless said otherwise.
    pub pool_percent: String,
    /// What happens to fragments without room: `grow` (the pool grows and the frame is rendered
    /// again) or `drop`.
    pub pool_policy: String,
    /// The intervals of depth complexity under bma: `powers-of-two` unless said otherwise,
    /// `optimal`, or upper bounds joined by hyphens.
    pub intervals: String,
    /// The method, where it is one whole: `dual_peel` of `dual_peel/passes4`.
    pub method: String,
    /// The size asked of the method: `passes4`; empty where none is.
    pub method_size: String,
}

/// Whether a part of a name is a word of lower-case letters, digits and `_`.
fn is_word(part: &str) -> bool {
    part.starts_with(|c: char| c.is_ascii_lowercase())
        && part.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

impl Technique {
    /// Takes a coordinate apart.
    #[must_use]
    pub fn parse(coordinate: &str) -> Self {
        let whole = Self { coordinate: coordinate.to_owned(), ..Self::default() };
        let parts: Vec<&str> = coordinate.split('/').collect();
        // A way of drawing spheres has axes of its own.
        if parts[0] == "spheres" {
            return whole;
        }
        if parts.len() <= 2 && parts.iter().all(|part| is_word(part)) {
            let method_size = parts.get(1).copied().unwrap_or_default().to_owned();
            return Self { method: parts[0].to_owned(), method_size, ..whole };
        }
        let [capture, schedule, sort, shader_stage, max, options @ ..] = parts.as_slice() else {
            return whole;
        };
        let (mut ties, mut pool_percent, mut pool_policy) = ("total", "100", "grow");
        let mut intervals = POWERS_OF_TWO;
        for option in options {
            if let Some(rule) = option.strip_prefix("ties-") {
                ties = rule;
            } else if let Some(pool) = option.strip_prefix("pool") {
                (pool_percent, pool_policy) = match pool.split_once('-') {
                    None => (pool, "grow"),
                    Some((percent, "drop")) => (percent, "drop"),
                    Some(_) => return whole,
                };
            } else if let Some(bounds) = option.strip_prefix("intervals") {
                intervals = bounds.strip_prefix('-').unwrap_or(bounds);
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
            pool_policy: pool_policy.to_owned(),
            intervals: intervals.to_owned(),
            ..whole
        }
    }

    /// Whether it is a method, which has no parts to tell it apart by.
    #[must_use]
    pub fn is_method(&self) -> bool {
        !self.method.is_empty()
    }

    /// Whether the pool starts with the room that is needed, as it does unless said otherwise.
    #[must_use]
    pub fn whole_pool(&self) -> bool {
        self.pool_percent == "100" && self.pool_policy == "grow"
    }

    /// Whether intervals are powers of two, as they are unless said otherwise.
    #[must_use]
    pub fn powers_of_two(&self) -> bool {
        self.intervals == POWERS_OF_TWO
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

/// A scene's overridden parameters: `layers` is `20` in `grid{layers=20}`.
#[must_use]
pub fn scene_parameters(scene: &str) -> BTreeMap<&str, &str> {
    let braced = scene.split_once('{').and_then(|(_, rest)| rest.strip_suffix('}'));
    let pairs = braced.unwrap_or("").split(',');
    pairs.filter_map(|pair| pair.split_once('=')).map(|(k, v)| (k.trim(), v.trim())).collect()
}

/// The camera path and the frame that a view's name means (`path@frame`), if it names a frame.
#[must_use]
pub fn path_frame(view: &str) -> Option<(&str, u32)> {
    let (path, frame) = view.split_once('@')?;
    Some((path, frame.parse().ok()?))
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
        assert!(technique.whole_pool());
    }

    #[test]
    fn a_pool_has_a_size_and_a_policy() {
        let pool = |coordinate: &str| {
            let technique = Technique::parse(coordinate);
            let whole = technique.whole_pool();
            (technique.pool_percent, technique.pool_policy, whole)
        };
        let expected = |percent: &str, policy: &str| (percent.to_owned(), policy.to_owned(), false);
        assert_eq!(pool("a/b/c/d/e/ties-depth/pool50"), expected("50", "grow"));
        assert_eq!(pool("a/b/c/d/e/pool25-drop"), expected("25", "drop"));
        // Room for all, and yet another technique than the usual one.
        assert_eq!(pool("a/b/c/d/e/pool100-drop"), expected("100", "drop"));
        assert_eq!(pool("a/b/c/d/e/pool25-spill"), expected("", ""));
    }

    #[test]
    fn intervals_are_powers_of_two_unless_said_otherwise() {
        let intervals = |coordinate: &str| Technique::parse(coordinate).intervals;
        assert!(Technique::parse("a/b/c/d/e").powers_of_two());
        assert_eq!(intervals("a/b/c/d/e/ties-depth/intervals4-12-40"), "4-12-40");
        assert_eq!(intervals("a/b/c/d/e/pool50/intervals-optimal"), "optimal");
        assert!(!Technique::parse("a/b/c/d/e/intervals-optimal").powers_of_two());
    }

    #[test]
    fn other_methods_keep_their_coordinate() {
        let technique = Technique::parse("depth-peel/peak");
        assert_eq!(technique.coordinate, "depth-peel/peak");
        assert_eq!(technique.sort, "");
        assert!(!technique.is_method());
        // An option that is not known makes it another kind of coordinate.
        assert_eq!(Technique::parse("a/b/c/d/e/f").capture, "");
    }

    #[test]
    fn methods_have_a_name_and_a_size() {
        let technique = Technique::parse("dual_peel/passes4");
        assert_eq!(
            (&*technique.method, &*technique.method_size, &*technique.coordinate),
            ("dual_peel", "passes4", "dual_peel/passes4")
        );
        // Nothing that asks for parts finds them.
        assert!(technique.sort.is_empty() && !technique.whole_pool() && !technique.truncated());
        let technique = Technique::parse("weighted");
        assert!(technique.is_method() && technique.method_size.is_empty());
        assert!(!Technique::parse("linked_list/base/rbs/compute/peak").is_method());
        assert!(!Technique::parse("array-probe/local/compute/size8").is_method());
    }

    #[test]
    fn a_frame_is_of_a_path() {
        assert_eq!(path_frame("fly@12"), Some(("fly", 12)));
        assert_eq!(
            (path_frame("front"), path_frame("fly@"), path_frame("fly@*")),
            (None, None, None)
        );
    }

    #[test]
    fn a_scene_has_a_name() {
        assert_eq!(scene_name("grid{layers=20}"), "grid");
        assert_eq!(scene_name("planes"), "planes");
        let parameters = scene_parameters("grid{layers=20,size=0.5}");
        assert_eq!(parameters.into_iter().collect::<Vec<_>>(), [("layers", "20"), ("size", "0.5")]);
        assert!(scene_parameters("planes").is_empty() && scene_parameters("grid{size").is_empty());
    }
}
