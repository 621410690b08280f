//! The rule by which a cell of a stability experiment gets its word, from its record alone.

use analysis::{CellResult, State};
use oit_record::{LOST, Verdict, Verification};

use crate::canvas::Colour;

/// What became of a technique in a case, from the best to the worst.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(super) enum Word {
    /// Exact, as it must be.
    Right,
    /// Not exact, and nowhere off by more than 1/255.
    Close,
    /// Not exact, on a camera path: its error stays from frame to frame, to 1/255.
    Steady,
    /// Not exact, and off by more.
    Off,
    /// It says that it cannot.
    Refused,
    /// From one frame of a camera path to the next its error changes by more than 1/255.
    Flickers,
    /// The same triangles in another order give another picture, by more than 1/255.
    Moves,
    /// Runs of one frame give different pictures.
    Varies,
    /// Off by half of a channel or more.
    Lost,
    /// Triangles are drawn that no picture should have.
    Drawn,
    /// A pixel that is not a number, or infinite.
    NotFinite,
    /// It must be exact and is not.
    Wrong,
    /// A crash, a hang, an error of the driver.
    Broke,
}

impl Word {
    /// All, with how each is written, what is behind it and what it means.
    pub(super) const ALL: [(Self, &'static str, Colour, &'static str); 13] = [
        (
            Self::Right,
            "right",
            Colour(0xcf, 0xe8, 0xd3),
            "exact, as it must be, and the same in every run",
        ),
        (
            Self::Close,
            "close",
            Colour(0xe2, 0xf1, 0xd8),
            "approximate, and nowhere off by more than 1/255; with the largest error",
        ),
        (
            Self::Steady,
            "steady",
            Colour(0xe2, 0xf1, 0xd8),
            "approximate, and from frame to frame its error changes by 1/255 at most; with the largest change",
        ),
        (
            Self::Off,
            "off",
            Colour(0xfb, 0xf2, 0xcb),
            "off by more, as approximate methods may be, and methods that lose fragments at one depth; pixels off by more than 1/255 and the largest error",
        ),
        (Self::Refused, "refused", Colour(0xe3, 0xe3, 0xe3), "it says that it cannot, and why"),
        (
            Self::Flickers,
            "flickers",
            Colour(0xf9, 0xdc, 0xbd),
            "from one frame to the next its picture changes by more than 1/255 more or less than the right one; on how many pixels at most, and by how much",
        ),
        (
            Self::Moves,
            "moves",
            Colour(0xf9, 0xdc, 0xbd),
            "the same triangles submitted in another order give another picture; on how many pixels by more than 1/255, and by how much",
        ),
        (
            Self::Varies,
            "varies",
            Colour(0xf7, 0xc9, 0xa3),
            "runs of one frame give different pictures; on how many pixels in any bit",
        ),
        (
            Self::Lost,
            "lost",
            Colour(0xf3, 0xb3, 0x9b),
            "off by half of a channel or more; pixels and error",
        ),
        (
            Self::Drawn,
            "drawn",
            Colour(0xee, 0x9a, 0x8d),
            "damaged triangles are drawn: the frame has other fragments than without them",
        ),
        (
            Self::NotFinite,
            "not finite",
            Colour(0xee, 0x9a, 0x8d),
            "a pixel is not a number, or infinite; pixels",
        ),
        (
            Self::Wrong,
            "wrong",
            Colour(0xee, 0x9a, 0x8d),
            "it must be exact and is not; pixels, error, and why",
        ),
        (Self::Broke, "broke", Colour(0xdd, 0x80, 0x80), "a crash, a hang or an error, and which"),
    ];

    fn entry(self) -> &'static (Self, &'static str, Colour, &'static str) {
        let found = Self::ALL.iter().find(|(word, ..)| *word == self);
        found.unwrap_or(&Self::ALL[0])
    }

    /// How it is written.
    pub(super) fn text(self) -> &'static str {
        self.entry().1
    }

    /// What is behind it.
    pub(super) fn colour(self) -> Colour {
        self.entry().2
    }

    /// Whether pictures of it are shown: something is not as it should be.
    pub(super) fn breaks(self) -> bool {
        self >= Self::Flickers
    }
}

/// What a case is about, besides the picture.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    /// One frame.
    Frame,
    /// The triangles of the case before in another order.
    Shuffled,
    /// The frames of a camera path.
    Path,
    /// A mesh that is damaged, and whether the device drew what it must not.
    Damaged { drawn: bool },
}

/// What became of a cell.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Finding {
    /// The word.
    pub(super) word: Word,
    /// The figure that goes with it; empty where there is none.
    pub(super) figure: String,
    /// Why, where it is refused, wrong or broke.
    pub(super) reason: Option<String>,
    /// Orders findings of one word: the larger the worse.
    pub(super) size: f64,
}

/// Pixels off by more than a step of eight bits, and the largest error.
fn px_and_error(px: u64, error: f64) -> String {
    format!("{px} px, {}", error_text(error))
}

/// An error to two digits.
pub(super) fn error_text(error: f64) -> String {
    match error {
        0.0 => "0".to_owned(),
        e if e < 0.001 => format!("{e:.0e}"),
        e => format!("{e:.3}"),
    }
}

/// The word of a cell, by the first rule that holds. Nothing of a cell that was not tried.
pub(super) fn find(cell: &CellResult, kind: Kind) -> Option<Finding> {
    let reason = cell.reason.clone();
    let without = |word, reason| Finding { word, figure: String::new(), reason, size: 0.0 };
    match (cell.state, &cell.verification) {
        (State::Failed, _) => Some(without(Word::Broke, reason)),
        (State::Skipped, _) => Some(without(Word::Refused, reason)),
        (_, None) => None,
        (_, Some(result)) => {
            let mut found = of_picture(result, kind);
            if found.word == Word::Wrong {
                found.reason = reason;
            }
            // Beside what is worse.
            let change = result.stability.as_ref().and_then(|stability| stability.change);
            let moves = kind == Kind::Shuffled && change.is_some_and(|change| change.px > 0);
            if moves && found.word > Word::Moves {
                found.figure += ", moves";
            }
            let pictures = result.stability.as_ref().map_or(1, |stability| stability.pictures);
            if pictures > 1 && found.word > Word::Varies {
                found.figure += ", varies";
            }
            Some(found)
        }
    }
}

fn of_picture(result: &Verification, kind: Kind) -> Finding {
    let Verification { wrong_px, max_error, .. } = *result;
    let found = |word, figure, size| Finding { word, figure, reason: None, size };
    let off = |word| found(word, px_and_error(wrong_px, max_error), max_error);
    let stability = result.stability.as_ref();
    let change = stability.and_then(|stability| stability.change);
    let exact = result.verdict == Verdict::Exact;
    // A picture that is not finite is recorded with the largest error there is.
    let finite = max_error < f64::MAX && result.max_alpha_error < f64::MAX;
    if result.verdict == Verdict::Wrong && finite {
        return off(Word::Wrong);
    }
    if !finite {
        return found(Word::NotFinite, format!("{wrong_px} px"), wrong_px as f64);
    }
    if let Kind::Damaged { drawn: true } = kind {
        return found(Word::Drawn, String::new(), 0.0);
    }
    if max_error >= LOST {
        return off(Word::Lost);
    }
    if stability.is_some_and(|stability| stability.pictures > 1) {
        let px = result.repeat_differs_px.unwrap_or(0);
        return found(Word::Varies, format!("{px} px"), px as f64);
    }
    match (kind, change) {
        (Kind::Shuffled, Some(change)) if change.px > 0 => {
            return found(Word::Moves, px_and_error(change.px, change.max), change.max);
        }
        (Kind::Path, Some(change)) if change.px > 0 => {
            return found(Word::Flickers, px_and_error(change.px, change.max), change.max);
        }
        (Kind::Path, Some(change)) if !exact => {
            return found(Word::Steady, error_text(change.max), change.max);
        }
        _ => {}
    }
    match (exact, wrong_px) {
        (true, 0) => found(Word::Right, String::new(), 0.0),
        (false, 0) => found(Word::Close, error_text(max_error), max_error),
        _ => off(Word::Off),
    }
}

/// The worst of several findings.
pub(super) fn worst(findings: impl IntoIterator<Item = Finding>) -> Option<Finding> {
    findings.into_iter().max_by(|a, b| a.word.cmp(&b.word).then(a.size.total_cmp(&b.size)))
}
