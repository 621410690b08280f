//! The two scenes of the layered fragment buffer chapter, and the techniques it times on them.

/// A scene of the chapter.
pub(crate) struct LfbView {
    /// The chapter's name.
    pub(crate) paper: &'static str,
    /// The scene here.
    pub(crate) scene: &'static str,
    /// The view here.
    pub(crate) view: &'static str,
    /// Fragments that are white in Figure 20.9.
    pub(crate) white: u32,
}

/// The chapter's scenes, in its order.
pub(crate) const VIEWS: [LfbView; 2] = [
    LfbView { paper: "Dragon", scene: "dragon", view: "front", white: 8 },
    LfbView { paper: "Atrium", scene: "atrium", view: "lfb", white: 32 },
];

/// The chapter's short names of its two layouts, and their captures here.
pub(crate) const LAYOUTS: [(&str, &str); 2] = [("L", "linearized"), ("LL", "linked_list")];

/// The schedule and stage nearest to the chapter's: one program, empty pixels masked by the stencil.
pub(crate) const AS_PUBLISHED: (&str, &str) = ("base-stencil", "fragment");

impl LfbView {
    /// Whether a scene, by its name without parameters, and a view are this one.
    pub(crate) fn is(&self, scene: &str, view: &str) -> bool {
        (self.scene, self.view) == (scene, view)
    }
}
