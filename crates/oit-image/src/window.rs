//! The part of a picture that is looked at closely.

/// Pixels a row and rows of the detail of a picture that is kept beside a record. So many pixels of a
/// picture take less than 100 kB as PNG.
pub const DETAIL_PX: (u32, u32) = (240, 150);

/// A rectangle of pixels.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Window {
    /// Its first column.
    pub x: u32,
    /// Its first row.
    pub y: u32,
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Window {
    /// The middle of a frame, of at most these columns and rows.
    #[must_use]
    pub fn middle(frame_width: u32, frame_height: u32, width: u32, height: u32) -> Self {
        let (width, height) = (width.min(frame_width), height.min(frame_height));
        Self { x: (frame_width - width) / 2, y: (frame_height - height) / 2, width, height }
    }

    /// The window of at most `width` x `height` pixels that holds the most fragments: of equal ones
    /// the topmost, and of these the leftmost. `counts` are those of a frame `frame_width` pixels wide,
    /// row by row; what is beyond its last whole row is left out. A frame that is smaller is the
    /// window itself.
    #[must_use]
    pub fn densest(counts: &[u32], frame_width: u32, width: u32, height: u32) -> Self {
        let frame_height = counts.len().checked_div(frame_width as usize).unwrap_or(0) as u32;
        let (width, height) = (width.min(frame_width), height.min(frame_height));
        let row_px = frame_width as usize;
        // Sums of columns over the window's rows, moved down row by row.
        let mut columns = vec![0_u64; row_px];
        let (mut best, mut found) = (0, Self { x: 0, y: 0, width, height });
        for bottom in 0..frame_height {
            for (x, sum) in columns.iter_mut().enumerate() {
                *sum += u64::from(counts[bottom as usize * row_px + x]);
                if let Some(above) = bottom.checked_sub(height) {
                    *sum -= u64::from(counts[above as usize * row_px + x]);
                }
            }
            let Some(y) = (bottom + 1).checked_sub(height) else { continue };
            let mut sum: u64 = columns[..width as usize].iter().sum();
            for x in 0..=frame_width - width {
                if x > 0 {
                    sum += columns[(x + width) as usize - 1];
                    sum -= columns[x as usize - 1];
                }
                if sum > best {
                    (best, found) = (sum, Self { x, y, ..found });
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_lies_in_the_middle() {
        let found = Window::middle(9, 8, 5, 3);
        assert_eq!(found, Window { x: 2, y: 2, width: 5, height: 3 });
        assert_eq!(Window::middle(4, 2, 5, 3), Window { x: 0, y: 0, width: 4, height: 2 });
    }

    #[test]
    fn the_window_with_the_most_is_found() {
        // Five columns and four rows; the two heavy pixels fit into one window of three by two.
        let mut counts = vec![1; 20];
        counts[2 * 5 + 1] = 9;
        counts[3 * 5 + 3] = 9;
        let found = Window::densest(&counts, 5, 3, 2);
        assert_eq!(found, Window { x: 1, y: 2, width: 3, height: 2 });
        // Every window of the same weight: the first.
        let even = Window::densest(&[1; 20], 5, 3, 2);
        assert_eq!((even.x, even.y), (0, 0));
    }

    #[test]
    fn the_sums_are_those_of_every_window_counted_by_itself() {
        let counts: Vec<u32> = (0..7 * 6).map(|i| (i * i * 31 + 7 * i) % 23).collect();
        let sum = |x: usize, y: usize| -> u32 {
            (y..y + 3)
                .flat_map(|row| (x..x + 2).map(move |column| row * 7 + column))
                .map(|i| counts[i])
                .sum()
        };
        let all = (0..=3).flat_map(|y| (0..=5).map(move |x| (x, y)));
        let most = all.map(|(x, y)| sum(x, y)).max().unwrap();
        let found = Window::densest(&counts, 7, 2, 3);
        assert_eq!(sum(found.x as usize, found.y as usize), most);
    }

    #[test]
    fn a_small_frame_is_its_window() {
        let found = Window::densest(&[3, 4], 2, 10, 10);
        assert_eq!(found, Window { x: 0, y: 0, width: 2, height: 1 });
        let none = Window::densest(&[], 0, 10, 10);
        assert_eq!((none.width, none.height), (0, 0));
    }
}
