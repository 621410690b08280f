//! What figures are drawn from: tables of records, and which run speaks for a view.

use std::collections::BTreeMap;

use analysis::{CellResult, RunInfo, Tables, path_frame, scene_name, scene_parameters};

/// The cells of one view of one scene at one resolution, all from one run on one device.
#[derive(Clone, Debug)]
pub(crate) struct Group<'a> {
    /// The run they are from.
    pub run: &'a RunInfo,
    /// The scene with its parameters.
    pub scene: &'a str,
    /// The view.
    pub view: &'a str,
    /// Pixels a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Every cell of the group, in the order of the run.
    pub cells: Vec<&'a CellResult>,
}

impl Group<'_> {
    /// The group's name in records.
    #[must_use]
    pub(crate) fn name(&self) -> String {
        format!("{}:{}@{}x{}", self.scene, self.view, self.width_px, self.height_px)
    }

    /// Scene and view, for titles.
    #[must_use]
    pub(crate) fn title(&self) -> String {
        format!("{}, {}", self.scene, self.view)
    }

    /// Scene and view, for file names.
    #[must_use]
    pub(crate) fn slug(&self) -> String {
        slug(&format!("{}-{}", self.scene, self.view))
    }

    /// Device, resolution and profile, for subtitles.
    #[must_use]
    pub(crate) fn conditions(&self) -> String {
        let (device, profile) = (self.run.device(), &self.run.run.profile);
        format!("{device}, {} × {} px, {profile} profile", self.width_px, self.height_px)
    }

    /// The device, for file names.
    #[must_use]
    pub(crate) fn device_slug(&self) -> String {
        slug(&self.run.device())
    }
}

/// Lower-case letters and digits with single hyphens between.
#[must_use]
pub(crate) fn slug(text: &str) -> String {
    let words: Vec<String> = text
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty())
        .map(str::to_ascii_lowercase)
        .collect();
    words.join("-")
}

/// The groups that hold cells a figure wants, one a device, scene and view, sorted by these. Frames of
/// camera paths are no views to most figures, and in [`frames`].
///
/// Where several runs of a device hold the view, one of them speaks for it, since times of
/// different runs are not put side by side: a `full` profile before another, then the one with the
/// most wanted cells charted, then the most at all, then the larger picture, then the one started last.
pub(crate) fn groups<'a>(
    tables: &'a Tables,
    wanted: impl Fn(&CellResult) -> bool,
) -> Vec<Group<'a>> {
    groups_with(tables, wanted, |_| true)
}

/// The same of groups that hold enough: a run that lacks what a figure compares does not speak for a
/// view, however many cells of it it has.
pub(crate) fn groups_with<'a>(
    tables: &'a Tables,
    wanted: impl Fn(&CellResult) -> bool,
    enough: impl Fn(&Group<'a>) -> bool,
) -> Vec<Group<'a>> {
    let no_frame = |group: &Group<'a>| path_frame(group.view).is_none() && enough(group);
    best(tables, wanted, no_frame)
}

/// The same of frames of camera paths.
pub(crate) fn frames<'a>(
    tables: &'a Tables,
    wanted: impl Fn(&CellResult) -> bool,
) -> Vec<Group<'a>> {
    best(tables, wanted, |group| path_frame(group.view).is_some())
}

/// Whether a run is of a stability experiment (`stability-...`). Its frames are tiny and sampled once,
/// for what becomes of the picture: its times say nothing.
#[must_use]
pub(crate) fn is_stability(run: &RunInfo) -> bool {
    run.run.experiment.starts_with("stability-")
}

/// Every group there is, of every run but those of stability experiments. Times of one are compared with
/// each other only.
#[must_use]
pub(crate) fn all_groups(tables: &Tables) -> Vec<Group<'_>> {
    let mut found: BTreeMap<(usize, String), Group> = BTreeMap::new();
    for cell in tables.results.iter().filter(|cell| !is_stability(&tables.runs[cell.run])) {
        let group = found.entry((cell.run, cell.name.group())).or_insert_with(|| Group {
            run: &tables.runs[cell.run],
            scene: &cell.name.scene,
            view: &cell.name.view,
            width_px: cell.name.width_px,
            height_px: cell.name.height_px,
            cells: Vec::new(),
        });
        group.cells.push(cell);
    }
    found.into_values().collect()
}

/// The groups that hold enough, one a device, scene and view.
fn best<'a>(
    tables: &'a Tables,
    wanted: impl Fn(&CellResult) -> bool,
    enough: impl Fn(&Group<'a>) -> bool,
) -> Vec<Group<'a>> {
    let charted = |group: &Group| {
        group.cells.iter().filter(|cell| !cell.times.is_empty() && wanted(cell)).count()
    };
    let mut best: BTreeMap<(String, &str, &str), Group<'a>> = BTreeMap::new();
    for group in all_groups(tables) {
        let rank = |group: &Group<'a>| {
            let area = u64::from(group.width_px) * u64::from(group.height_px);
            let run = &group.run.run;
            (
                run.profile == "full",
                charted(group),
                // Among them those that were refused.
                group.cells.iter().filter(|cell| wanted(cell)).count(),
                area,
                run.started.clone(),
                group.run.name.clone(),
            )
        };
        if charted(&group) == 0 || !enough(&group) {
            continue;
        }
        let key = (group.run.device(), group.scene, group.view);
        if best.get(&key).is_none_or(|other| rank(&group) > rank(other)) {
            best.insert(key, group);
        }
    }
    best.into_values().collect()
}

/// Groups by device, in the order of the devices.
#[must_use]
pub(crate) fn by_device(groups: Vec<Group<'_>>) -> BTreeMap<String, Vec<Group<'_>>> {
    let mut devices: BTreeMap<String, Vec<Group<'_>>> = BTreeMap::new();
    for group in groups {
        devices.entry(group.run.device()).or_default().push(group);
    }
    devices
}

/// The depth of the covered pixels, if it is the same in all, and how many there are.
#[must_use]
pub(crate) fn uniform_depth(group: &Group) -> Option<(u64, u64)> {
    let histogram = group.run.histogram(&group.name())?;
    let mut depths = (0_u64..).zip(histogram).skip(1).filter(|(_, pixels)| **pixels > 0);
    let (depth, &covered_px) = depths.next()?;
    depths.next().is_none().then_some((depth, covered_px))
}

/// The same where fragments come in random order of depth.
#[must_use]
pub(crate) fn random_depth(group: &Group) -> Option<u64> {
    let parameters = scene_parameters(group.scene);
    let random = parameters.get("order").is_some_and(|order| order.trim_matches('"') == "random");
    uniform_depth(group).filter(|_| random).map(|(depth, _)| depth)
}

/// The group of a scene, by its name without parameters or with them, and a view.
#[must_use]
pub(crate) fn view_of<'a, 'b>(
    groups: &'b [Group<'a>],
    scene: &str,
    view: &str,
) -> Option<&'b Group<'a>> {
    groups.iter().find(|group| is_view(group, scene, view))
}

/// Whether a group is of a scene, by its name without parameters or with them, and a view.
#[must_use]
pub(crate) fn is_view(group: &Group, scene: &str, view: &str) -> bool {
    let is_scene = group.scene == scene || scene_name(group.scene) == scene;
    is_scene && group.view == view
}
