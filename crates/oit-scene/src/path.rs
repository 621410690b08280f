//! Camera paths: a view for each frame of a flight through a scene.

use std::path::Path;

use glam::Vec3;
use serde::Deserialize;
use toml::Spanned;

use crate::file::y_up;
use crate::{Camera, Fault, Problem, Projection, SceneError, parse_toml};

/// The most frames of a path: more than five minutes at 30 a second.
pub const MAX_FRAMES: u32 = 10_000;

/// Distances below this are none to a spline, in world units to the power of a half.
const NO_DISTANCE: f32 = 1e-6;

/// A camera that moves, and the frames at which it is looked through.
///
/// Eyes and targets each run through their keys on a centripetal Catmull-Rom spline: the tangent at
/// a key follows from its two neighbours, with knots as far apart as the square root of the distance
/// between keys (Barry and Goldman 1988; Yuksel, Schaefer and Keyser 2011), so that a spline has
/// neither loops nor cusps between two keys. Between keys the spline's parameter runs evenly from
/// one key's time to the next's, and so does the field of view. The neighbour that an open path
/// lacks at an end is its other neighbour mirrored.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPath {
    about: String,
    frames: u32,
    /// When a closed path is back at its first key.
    closes_at: Option<f32>,
    up: [f32; 3],
    near: f32,
    far: f32,
    /// Two or more, by rising time.
    keys: Vec<Key>,
}

/// Where a path's camera is at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Key {
    time: f32,
    eye: Vec3,
    target: Vec3,
    fov_y_degrees: f32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PathFile {
    about: Spanned<String>,
    frames: Spanned<u32>,
    closes_at: Option<Spanned<f32>>,
    #[serde(default = "y_up")]
    up: [f32; 3],
    near: f32,
    far: f32,
    keys: Spanned<Vec<Spanned<KeyFile>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyFile {
    time: f32,
    eye: [f32; 3],
    target: [f32; 3],
    fov_y_degrees: f32,
}

impl CameraPath {
    /// Reads a path file.
    ///
    /// # Errors
    /// [`SceneError::Io`], and [`SceneError::Fault`] as [`Self::parse`] gives it.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| SceneError::Io { path: path.to_owned(), source })?;
        Ok(Self::parse(path, &text)?)
    }

    /// A path from the text of its file; `path` names it in errors.
    ///
    /// # Errors
    /// A [`Fault`] with the line of a key or word that is not of the format; of fewer than two keys;
    /// of times that do not rise or do not end before `closes_at`; and of the key after which a
    /// camera sees nothing on one of the frames: at no finite place, at its own target, looking
    /// along `up`, or through an impossible volume.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Fault> {
        let file: PathFile = parse_toml(path, text)?;
        let invalid =
            |span, sentence: String| Err(Fault::at(path, text, span, Problem::Invalid(sentence)));
        if file.about.get_ref().trim().is_empty() {
            return invalid(file.about.span(), "`about` must say what the path is".into());
        }
        let frames = *file.frames.get_ref();
        if !(2..=MAX_FRAMES).contains(&frames) {
            let sentence = format!("`frames` must be from 2 to {MAX_FRAMES}, not {frames}");
            return invalid(file.frames.span(), sentence);
        }
        let keys_span = file.keys.span();
        let files = file.keys.into_inner();
        if files.len() < 2 {
            return invalid(keys_span, format!("a path needs two keys, there are {}", files.len()));
        }
        let mut spans = Vec::with_capacity(files.len());
        let mut keys: Vec<Key> = Vec::with_capacity(files.len());
        for (index, key) in files.into_iter().enumerate() {
            let span = key.span();
            let KeyFile { time, eye, target, fov_y_degrees } = key.into_inner();
            if !time.is_finite() || keys.last().is_some_and(|before| time <= before.time) {
                let sentence = format!("key {index}: `time` must rise from key to key");
                return invalid(span, sentence);
            }
            spans.push(span);
            keys.push(Key { time, eye: eye.into(), target: target.into(), fov_y_degrees });
        }
        let closes_at = file.closes_at.as_ref().map(|time| *time.get_ref());
        if let Some(time) = &file.closes_at
            && !(time.get_ref().is_finite() && *time.get_ref() > keys[keys.len() - 1].time)
        {
            return invalid(time.span(), "`closes_at` must be after the last key's `time`".into());
        }
        let (up, near, far) = (file.up, file.near, file.far);
        let about = file.about.into_inner();
        let found = Self { about, frames, closes_at, up, near, far, keys };
        for (index, key) in found.keys.iter().enumerate() {
            if let Some(sentence) = found.look(key.eye, key.target, key.fov_y_degrees).fault() {
                return invalid(spans[index].clone(), format!("key {index}: {sentence}"));
            }
        }
        for frame in 0..frames {
            if let Some(sentence) = found.camera(frame).fault() {
                let (index, _) = found.segment(found.time(frame));
                let sentence = format!("frame {frame}, after key {index}: {sentence}");
                return invalid(spans[index].clone(), sentence);
            }
        }
        Ok(found)
    }

    /// Prose: what the path is.
    #[must_use]
    pub fn about(&self) -> &str {
        &self.about
    }

    /// How many frames it has.
    #[must_use]
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// Whether it ends where it begins.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.closes_at.is_some()
    }

    /// The camera of a frame, counted from 0. Frames are evenly spaced in time. On a closed path
    /// frame [`Self::frames`] would be frame 0 again, and is; an open one stays at its last.
    #[must_use]
    pub fn camera(&self, frame: u32) -> Camera {
        let time = self.time(frame);
        let (index, u) = self.segment(time);
        let around = |of: fn(&Key) -> Vec3| {
            let at = |offset: isize| self.neighbour(index as isize + offset).map(of);
            let (from, to) = (of(&self.keys[index]), at(1).unwrap_or(of(&self.keys[index])));
            let points =
                [at(-1).unwrap_or(2.0 * from - to), from, to, at(2).unwrap_or(2.0 * to - from)];
            spline(points, u)
        };
        let from = self.keys[index].fov_y_degrees;
        let to = self.neighbour(index as isize + 1).map_or(from, |key| key.fov_y_degrees);
        self.look(around(|key| key.eye), around(|key| key.target), from + (to - from) * u)
    }

    fn look(&self, eye: Vec3, target: Vec3, fov_y_degrees: f32) -> Camera {
        let (near, far) = (self.near, self.far);
        let projection = Projection::Perspective { fov_y_degrees, near, far };
        Camera { eye: eye.into(), target: target.into(), up: self.up, projection }
    }

    fn time(&self, frame: u32) -> f32 {
        let (first, last) = (self.keys[0].time, self.keys[self.keys.len() - 1].time);
        let share = match self.closes_at {
            Some(_) => f64::from(frame % self.frames) / f64::from(self.frames),
            None => f64::from(frame.min(self.frames - 1)) / f64::from(self.frames - 1),
        };
        let (first, end) = (f64::from(first), f64::from(self.closes_at.unwrap_or(last)));
        (first + (end - first) * share) as f32
    }

    /// The key before a time, and where between it and the next the time lies, from 0 to 1.
    fn segment(&self, time: f32) -> (usize, f32) {
        let after = self.keys.partition_point(|key| key.time <= time);
        // An open path's last key ends the segment before it.
        let last = self.keys.len() - if self.is_closed() { 1 } else { 2 };
        let index = after.saturating_sub(1).min(last);
        let from = f64::from(self.keys[index].time);
        let to = match self.keys.get(index + 1) {
            Some(next) => next.time,
            None => self.closes_at.unwrap_or(self.keys[index].time),
        };
        let u = (f64::from(time) - from) / (f64::from(to) - from);
        (index, u.clamp(0.0, 1.0) as f32)
    }

    /// The key of this number, counted on around a closed path; none beyond the ends of an open one.
    fn neighbour(&self, index: isize) -> Option<&Key> {
        let count = self.keys.len() as isize;
        let index = if self.is_closed() { index.rem_euclid(count) } else { index };
        self.keys.get(usize::try_from(index).ok()?)
    }
}

/// The centripetal Catmull-Rom spline between the middle two of four points, as a Hermite curve:
/// `u` runs from 0 to 1.
fn spline([p0, p1, p2, p3]: [Vec3; 4], u: f32) -> Vec3 {
    let knots = |from: Vec3, to: Vec3| (to - from).length().sqrt();
    let own = knots(p1, p2);
    if own < NO_DISTANCE {
        return p1.lerp(p2, u);
    }
    // A neighbour in the same place gives no direction: as far away as the other key it does none.
    let or_own = |distance: f32| if distance < NO_DISTANCE { own } else { distance };
    let (before, after) = (or_own(knots(p0, p1)), or_own(knots(p2, p3)));
    let chord = (p2 - p1) / own;
    let from = own * ((p1 - p0) / before - (p2 - p0) / (before + own) + chord);
    let to = own * (chord - (p3 - p1) / (own + after) + (p3 - p2) / after);
    let (u2, u3) = (u * u, u * u * u);
    p1 * (2.0 * u3 - 3.0 * u2 + 1.0)
        + from * (u3 - 2.0 * u2 + u)
        + p2 * (3.0 * u2 - 2.0 * u3)
        + to * (u3 - u2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SQUARE: &str = r#"about = "Round a square."
frames = 40
closes_at = 8.0
near = 0.1
far = 9.0
keys = [
    { time = 0.0, eye = [1.0, 0.0, 1.0], target = [0.0, 0.0, 0.0], fov_y_degrees = 50.0 },
    { time = 2.0, eye = [1.0, 0.0, -1.0], target = [0.0, 0.0, 0.0], fov_y_degrees = 60.0 },
    { time = 4.0, eye = [-1.0, 0.0, -1.0], target = [0.0, 0.0, 0.0], fov_y_degrees = 70.0 },
    { time = 6.0, eye = [-1.0, 0.0, 1.0], target = [0.0, 0.0, 0.0], fov_y_degrees = 60.0 },
]
"#;

    fn parse(text: &str) -> Result<CameraPath, Fault> {
        CameraPath::parse(Path::new("p.toml"), text)
    }

    fn eye(path: &CameraPath, frame: u32) -> Vec3 {
        path.camera(frame).eye.into()
    }

    fn fov(camera: &Camera) -> f32 {
        match camera.projection {
            Projection::Perspective { fov_y_degrees, .. } => fov_y_degrees,
            Projection::Orthographic { .. } => f32::NAN,
        }
    }

    #[test]
    fn a_closed_path_ends_where_it_begins() {
        let path = parse(SQUARE).unwrap();
        assert!(path.is_closed());
        assert_eq!((path.frames(), path.camera(40)), (40, path.camera(0)));
        assert_eq!(path.camera(0).eye, [1.0, 0.0, 1.0]);
        assert_eq!(path.camera(30).eye, [-1.0, 0.0, 1.0]);
        assert_eq!(fov(&path.camera(5)), 55.0);
        assert_eq!(fov(&path.camera(35)), 55.0);
        // By symmetry the last side is the first, turned by a quarter.
        let (first, last) = (eye(&path, 5), eye(&path, 35));
        assert!((first.x - last.z).abs() < 1e-6 && first.x > 1.0, "{first} {last}");
    }

    #[test]
    fn no_frame_is_far_from_the_one_before() {
        let path = parse(SQUARE).unwrap();
        let steps: Vec<Vec3> = (0..40).map(|i| eye(&path, i + 1) - eye(&path, i)).collect();
        for pair in [&steps[..], &[steps[0]]].concat().windows(2) {
            assert!((0.1..0.3).contains(&pair[0].length()), "{}", pair[0]);
            // Two sides of the square meet in a curve, not in a corner.
            assert!(pair[0].normalize().dot(pair[1].normalize()) > 0.9, "{pair:?}");
        }
    }

    #[test]
    fn an_open_path_ends_at_its_last_key() {
        let path = parse(&SQUARE.replace("closes_at = 8.0\n", "")).unwrap();
        assert!(!path.is_closed());
        assert_eq!(path.camera(0).eye, [1.0, 0.0, 1.0]);
        assert_eq!(path.camera(39).eye, [-1.0, 0.0, 1.0]);
        assert_eq!(path.camera(40), path.camera(39));
        assert_eq!(path.camera(13).eye, [1.0, 0.0, -1.0]);
    }

    #[test]
    fn a_spline_runs_straight_through_points_on_a_line() {
        let points = [0.0, 1.0, 5.0, 6.0].map(|x| Vec3::new(x, 2.0 * x, 0.0));
        let mut last = points[1].x;
        for step in 1..=10 {
            let at = spline(points, step as f32 / 10.0);
            assert!((at.y - 2.0 * at.x).abs() < 1e-5 && at.x > last, "{at}");
            last = at.x;
        }
        assert_eq!(spline([points[1]; 4], 0.5), points[1]);
        // Neighbours in one place with a key do no harm.
        let [_, a, b, _] = points;
        assert!(spline([a, a, b, b], 0.5).abs_diff_eq(a.midpoint(b), 1e-5));
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        let mistakes = [
            ("frames = 40", "frame = 40", ":2: unknown key `frame`, the nearest valid: `frames`"),
            ("frames = 40", "frames = 1", ":2: `frames` must be from 2 to 10000, not 1"),
            ("frames = 40", "frames = 10001", ":2: `frames` must be from 2 to 10000, not 10001"),
            ("frames = 40", "frames = -1", ":2: invalid value: integer `-1`, expected u32"),
            ("Round a square.", " ", ":1: `about` must say what the path is"),
            ("closes_at = 8.0", "closes_at = 6.0", ":3: `closes_at` must be after the last key's"),
            ("closes_at = 8.0", "closes_at = nan", ":3: `closes_at` must be after the last key's"),
            ("time = 4.0", "time = 2.0", ":9: key 2: `time` must rise from key to key"),
            ("time = 4.0", "time = nan", ":9: key 2: `time` must rise from key to key"),
            ("time = 4.0", "tiem = 4.0", ":9: unknown key `tiem`, the nearest valid: `time`"),
            ("[-1.0, 0.0, 1.0]", "[nan, 0.0, 1.0]", ":10: key 3: `eye` and `target` must be two"),
            ("[-1.0, 0.0, 1.0]", "[0.0, 3.0, 0.0]", ":10: key 3: `up` must not be parallel"),
            ("[-1.0, 0.0, 1.0]", "[0.0, 0.0, 0.0]", ":10: key 3: `eye` and `target` must be two"),
            ("[-1.0, 0.0, 1.0]", "[0.0, 1.0]", ":10: invalid length 2"),
            ("= 70.0", "= 180.0", ":9: key 2: `fov_y_degrees` must be between 0 and 180"),
            ("near = 0.1", "near = 10.0", ":7: key 0: `near` must be below `far`"),
        ];
        for (old, new, message) in mistakes {
            assert!(SQUARE.contains(old), "{old}");
            let error = parse(&SQUARE.replacen(old, new, 1)).unwrap_err().to_string();
            assert!(error.starts_with(&format!("p.toml{message}")), "`{new}` gave: {error}");
        }
        let one = SQUARE.lines().take(7).collect::<Vec<_>>().join("\n") + "\n]\n";
        let error = parse(&one).unwrap_err().to_string();
        assert_eq!(error, "p.toml:6: a path needs two keys, there are 1");
        // Each key can see, but between them the camera looks straight down.
        let above = "about = \"Above.\"\nframes = 3\nnear = 0.1\nfar = 9.0\nkeys = [\n\
            { time = 0.0, eye = [1, 5, 0], target = [0, 0, 0], fov_y_degrees = 50 },\n\
            { time = 1.0, eye = [-1, 5, 0], target = [0, 0, 0], fov_y_degrees = 50 },\n]\n";
        let error = parse(above).unwrap_err().to_string();
        assert!(error.starts_with("p.toml:6: frame 1, after key 0: `up` must not be"), "{error}");
    }

    fn number() -> impl Strategy<Value = String> {
        prop_oneof![
            (-9.0f32..9.0).prop_map(|x| format!("{x:?}")),
            any::<f32>().prop_map(|x| format!("{x:?}").to_lowercase()),
            Just("3e38".to_owned()),
            Just("1e-45".to_owned()),
        ]
    }

    proptest! {
        #[test]
        fn no_file_makes_it_panic_or_blind(
            numbers in prop::collection::vec(number(), 0..64),
            frames in 0u32..200,
            closed in any::<bool>(),
        ) {
            let mut text = format!("about = \"x\"\nframes = {frames}\nnear = 0.1\nfar = 9.0\n");
            if closed {
                text += "closes_at = 100.0\n";
            }
            for (index, n) in numbers.chunks_exact(7).enumerate() {
                text += &format!(
                    "[[keys]]\ntime = {index}.0\neye = [{}, {}, {}]\ntarget = [{}, {}, {}]\n\
                    fov_y_degrees = {}\n",
                    n[0], n[1], n[2], n[3], n[4], n[5], n[6],
                );
            }
            if let Ok(path) = parse(&text) {
                for frame in 0..=2 * frames {
                    prop_assert_eq!(path.camera(frame).fault(), None);
                }
            }
        }

        #[test]
        fn no_text_makes_it_panic(text in "(about|frames|keys|time|=|\\[|\\]|\\{|\\}|nan|[0-9]|\n|\"| )*") {
            let _ = parse(&text);
        }
    }
}
