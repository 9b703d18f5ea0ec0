//! One level of a texture as kernels see it: plain elements and where they stand.

/// Up to four channels of one level. Texel (x, y) begins at `origin + y * row + x * lanes`.
#[derive(Clone, Copy, Debug)]
pub struct Plane<'a, T> {
    /// The elements.
    pub data: &'a [T],
    /// Index of the first channel of texel (0, 0).
    pub origin: usize,
    /// Elements from one row to the next.
    pub row: usize,
    /// Elements from one texel to the next.
    pub lanes: usize,
    /// Channels to read, 1 to 4; not more than `lanes`.
    pub channels: usize,
    /// Texels in a row.
    pub width: i32,
    /// Rows.
    pub height: i32,
    /// Readable columns: `columns.0..=columns.1`, one more than the picture on each side where an apron
    /// continues it by its wrap mode.
    pub columns: (i32, i32),
    /// Readable rows, likewise.
    pub rows: (i32, i32),
}

impl<T: Copy + Default> Plane<'_, T> {
    /// The channels of the texel at a readable place, the rest filled with zero codes.
    #[inline(always)]
    pub fn texel(&self, x: i32, y: i32) -> [T; 4] {
        debug_assert!(self.is_readable(x, y));
        let start = self.origin as isize + y as isize * self.row as isize + x as isize * self.lanes as isize;
        let start = start as usize;
        if self.channels == 4 {
            let t = &self.data[start..start + 4];
            [t[0], t[1], t[2], t[3]]
        } else {
            let t = &self.data[start..start + self.channels];
            let at = |i: usize| t.get(i).copied().unwrap_or_default();
            [at(0), at(1), at(2), T::default()]
        }
    }

    /// The 2x2 texels from a readable place on, row by row; (x + 1, y + 1) must be readable too.
    #[inline(always)]
    pub fn quad(&self, x: i32, y: i32) -> [[T; 4]; 4] {
        debug_assert!(self.covers(x, y, x + 1, y + 1));
        let start = self.origin as isize + y as isize * self.row as isize + x as isize * self.lanes as isize;
        let start = start as usize;
        if self.channels == 4 && self.lanes == 4 {
            let (a, b) = (&self.data[start..start + 8], &self.data[start + self.row..start + self.row + 8]);
            return [
                [a[0], a[1], a[2], a[3]],
                [a[4], a[5], a[6], a[7]],
                [b[0], b[1], b[2], b[3]],
                [b[4], b[5], b[6], b[7]],
            ];
        }
        [self.texel(x, y), self.texel(x + 1, y), self.texel(x, y + 1), self.texel(x + 1, y + 1)]
    }

    /// Where the texel (x, y) begins.
    #[inline(always)]
    pub fn at(&self, x: i32, y: i32) -> usize {
        (self.origin as isize + y as isize * self.row as isize + x as isize * self.lanes as isize) as usize
    }

    /// The texels that begin at `at` and one texel further, where they are eight elements in a row.
    #[inline(always)]
    pub fn packed_pair(&self, at: usize) -> Option<&[T; 8]> {
        if self.lanes == 4 { self.data[at..at + 8].try_into().ok() } else { None }
    }

    /// The channels of the texels that begin at `at` and one texel further, four each, the rest filled with zero codes.
    #[inline(always)]
    pub fn pair(&self, at: usize) -> [T; 8] {
        let zero = T::default();
        if self.lanes == 1 {
            let t = &self.data[at..at + 2];
            return [t[0], zero, zero, zero, t[1], zero, zero, zero];
        }
        if self.lanes == 3 && self.channels == 3 {
            let t = &self.data[at..at + 6];
            return [t[0], t[1], t[2], zero, t[3], t[4], t[5], zero];
        }
        let last = &self.data[at + self.lanes..at + self.lanes + self.channels];
        let first = &self.data[at..at + self.channels];
        let (mut a, mut b) = ([zero; 4], [zero; 4]);
        if self.channels == 4 {
            (a, b) = ([first[0], first[1], first[2], first[3]], [last[0], last[1], last[2], last[3]]);
        } else {
            a.iter_mut().zip(first).for_each(|(a, t)| *a = *t);
            b.iter_mut().zip(last).for_each(|(b, t)| *b = *t);
        }
        [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]]
    }

    /// Whether the texel stands in the picture or its apron.
    #[inline(always)]
    pub fn is_readable(&self, x: i32, y: i32) -> bool {
        x >= self.columns.0 && x <= self.columns.1 && y >= self.rows.0 && y <= self.rows.1
    }

    /// Whether the block of texels (x0, y0) to (x1, y1), both included, is readable.
    #[inline(always)]
    pub fn covers(&self, x0: i32, y0: i32, x1: i32, y1: i32) -> bool {
        x0 >= self.columns.0 && x1 <= self.columns.1 && y0 >= self.rows.0 && y1 <= self.rows.1
    }
}
