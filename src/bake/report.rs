//! What happened while baking.

/// Bits that mark texels.
pub mod flag {
    /// At least one sample point lies on the low mesh and found the high mesh.
    pub const COVERED: u8 = 1;
    /// The texel is on the low mesh, but no sample found the high mesh; it is filled from its neighbours.
    pub const MISSED: u8 = 2;
    /// Some samples found the high mesh and some did not.
    pub const PARTLY_MISSED: u8 = 4;
    /// A line met several pieces of the high mesh that face it; the method decided.
    pub const AMBIGUOUS: u8 = 8;
    /// Several faces of the low mesh share the texel; the one of the lowest index was baked.
    pub const OVERLAPPING: u8 = 16;
}

/// Counts of a bake.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Texels of the map.
    pub texels: usize,
    /// Texels with an answer.
    pub covered: usize,
    /// Texels on the low mesh where no sample found the high mesh.
    pub missed: usize,
    /// Texels where some samples did and some did not.
    pub partly_missed: usize,
    /// Texels where a line met several pieces of the high mesh that face it.
    pub ambiguous: usize,
    /// Texels that several faces share.
    pub overlapping: usize,
    /// Lines cast from the low mesh, or closest points looked for.
    pub rays: u64,
    /// How far was looked, on both sides.
    pub distance: f64,
    /// Faces whose texture is mirrored.
    pub mirrored_faces: usize,
    /// Faces whose uv triangle has no area or is not finite: they are in no texel.
    pub degenerate_faces: usize,
    /// Faces that reach out of the unit square: what is outside is in no texel.
    pub outside_faces: usize,
    /// Edges of the high and of the low mesh where more than two faces meet, or two with opposite sense.
    pub non_manifold_edges: [usize; 2],
}

impl Report {
    /// Counts flags.
    pub(super) fn count(&mut self, flags: &[u8]) {
        let number = |bit| flags.iter().filter(|f| **f & bit != 0).count();
        self.covered = number(flag::COVERED);
        self.missed = number(flag::MISSED);
        self.partly_missed = number(flag::PARTLY_MISSED);
        self.ambiguous = number(flag::AMBIGUOUS);
        self.overlapping = number(flag::OVERLAPPING);
    }

    /// A sentence for each thing that makes a map wrong or incomplete, with what was done about it.
    ///
    /// ```
    /// let report = multum::bake::Report { covered: 9, missed: 1, ..Default::default() };
    /// assert!(report.warnings()[0].starts_with("1 texel of the low mesh found nothing"));
    /// ```
    pub fn warnings(&self) -> Vec<String> {
        let texels = |n: usize| if n == 1 { "1 texel".to_owned() } else { format!("{n} texels") };
        let faces = |n: usize| if n == 1 { "1 face".to_owned() } else { format!("{n} faces") };
        let [high, low] = self.non_manifold_edges;
        let mut told = Vec::new();
        if self.covered + self.missed == 0 {
            told.push("no triangle of the low mesh covers a texel: the map is empty".to_owned());
        }
        if self.missed > 0 {
            told.push(format!(
                "{} of the low mesh found nothing of the high mesh within {:.4}; filled from the neighbours",
                texels(self.missed),
                self.distance
            ));
        }
        if self.overlapping > 0 {
            told.push(format!(
                "{} shared by several faces; the face of the lowest index was baked",
                texels(self.overlapping)
            ));
        }
        if self.degenerate_faces > 0 {
            told.push(format!(
                "{} without an area in texture space; not baked",
                faces(self.degenerate_faces)
            ));
        }
        if self.outside_faces > 0 {
            told.push(format!(
                "{} outside [0, 1] in texture space; only what is inside was baked",
                faces(self.outside_faces)
            ));
        }
        if high + low > 0 {
            told.push(format!(
                "edges that are not manifold: {high} of the high mesh, {low} of the low mesh; baked as they are"
            ));
        }
        told
    }
}
