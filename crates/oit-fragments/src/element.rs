//! What a sort moves about of a fragment.

/// What a resolve program holds of each fragment while it sorts, and so how much it moves.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Element {
    /// All of a fragment of 64 bits: its colour and its depth key ([`Fragment`](crate::Fragment)).
    #[default]
    Narrow,
    /// All of a fragment of 128 bits: its depth key, and a colour and an opacity for each channel in
    /// halves. What direct sorting moves.
    Wide,
    /// Of a fragment of 128 bits its depth key, and where it lies: 64 bits. The rest is fetched when
    /// it is blended. What indirect sorting moves.
    Index,
}
