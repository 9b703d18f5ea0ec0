//! What the kernels read: the levels of the source as packed pictures, of a cube one picture a face with a texel of
//! its neighbours around it.

use super::Form;
use crate::encode::Format;
use crate::error::{Error, Result};
use crate::image::{AnyView, Element, Image, View};
use crate::kernel::remap::{Edge, Interpolation, Job, Outside, Sample, Source};
use crate::mapping::{Cube, Face, Layout};
use crate::pyramid::{Kind, Options, build_above, level_size, num_levels};
use crate::sphere::neighbour;
use crate::wrap::Wrap;
use glam::{DVec2, DVec3};
use std::sync::{Mutex, OnceLock};

/// The levels; those beyond the first are made when they are first asked for.
pub(super) struct Pictures<'a, T> {
    form: Form,
    /// One view, or one a face.
    views: Vec<View<'a, T>>,
    /// Faces of the first level in their frames.
    framed: Vec<Image>,
    format: Format,
    border: Vec<T>,
    above: OnceLock<Vec<Vec<Image>>>,
    making: Mutex<()>,
}

impl<'a, T: Element + Sample> Pictures<'a, T>
where
    View<'a, T>: Into<AnyView<'a>>,
    crate::image::Pixels: From<Vec<T>>,
{
    pub fn new(view: View<'a, T>, form: Form, format: Format, border: &[f64]) -> Result<Self> {
        let border = border.iter().map(|b| T::from_f64(*b)).collect();
        let mut made = Self {
            form,
            views: vec![view],
            framed: Vec::new(),
            format,
            border,
            above: OnceLock::new(),
            making: Mutex::new(()),
        };
        if let Form::Cube(layout) = form {
            let n = view.width() / layout.cells().0;
            made.views =
                Face::ALL.map(|face| face_view(&view, layout, face, n)).into_iter().collect::<Result<_>>()?;
            made.framed = framed(&made.views)?;
        }
        Ok(made)
    }

    /// Sides of the picture, or of a face.
    pub fn size(&self) -> DVec2 {
        DVec2::new(self.views[0].width() as f64, self.views[0].height() as f64)
    }

    /// Elements a pixel.
    pub fn channels(&self) -> usize {
        self.format.channels
    }

    /// The colour of places that there are not.
    pub fn border(&self) -> &[T] {
        &self.border
    }

    /// Index of the coarsest level.
    pub fn last_level(&self) -> usize {
        num_levels(self.views[0].width(), self.views[0].height()) - 1
    }

    /// Sides of a level, and texels around it.
    pub fn level_size(&self, level: usize) -> (DVec2, f64) {
        let side = |n: usize| level_size(n, level) as f64;
        let frame = if self.framed.is_empty() { 0.0 } else { 1.0 };
        (DVec2::new(side(self.views[0].width()), side(self.views[0].height())), frame)
    }

    /// What lies beyond the sides of a level.
    pub fn edges(&self) -> [Edge; 2] {
        match self.form.wrap() {
            [Wrap::Repeat, _] => [Edge::Repeat, Edge::Clamp],
            [Wrap::Border, _] => [Edge::Border; 2],
            _ => [Edge::Clamp; 2],
        }
    }

    /// A level of the picture, or of a face in its frame.
    pub fn view(&self, level: usize, face: usize) -> Result<View<'_, T>> {
        if level == 0 && self.framed.is_empty() {
            return Ok(self.views[face]);
        }
        let image = if level == 0 { &self.framed[face] } else { &self.above()?[face][level - 1] };
        T::of_view(&image.view()).ok_or_else(|| Error::type_("image", image.dtype().name(), T::DTYPE.name()))
    }

    /// A level, or a face of it, ready to be read.
    pub fn job(&self, level: usize, face: usize, interpolation: Interpolation) -> Result<Job<'_, T>> {
        let view = self.view(level, face)?;
        let source =
            Source::new(view.data(), view.width(), view.height(), view.channels(), view.row_stride())?;
        Job::new(source, interpolation, self.edges(), &self.border, Outside::Colour)
    }

    /// Levels from the second on, for each face.
    fn above(&self) -> Result<&[Vec<Image>]> {
        if let Some(made) = self.above.get() {
            return Ok(made);
        }
        // One thread makes them; the others wait.
        let _one = self.making.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(made) = self.above.get() {
            return Ok(made);
        }
        let options =
            Options { kind: Kind::Box, format: self.format, wrap: self.form.wrap(), coverage: None };
        let mut made: Vec<Vec<Image>> = (self.views.iter())
            .map(|view| build_above((*view).into(), &options, None))
            .collect::<Result<_>>()?;
        if !self.framed.is_empty() {
            for level in 0..made[0].len() {
                let views: Vec<View<'_, T>> =
                    made.iter().filter_map(|face| T::of_view(&face[level].view())).collect();
                let frames = framed(&views)?;
                for (face, image) in made.iter_mut().zip(frames) {
                    face[level] = image;
                }
            }
        }
        Ok(self.above.get_or_init(|| made))
    }
}

/// One face of a picture of six.
pub(super) fn face_view<'a, T: Element>(
    view: &View<'a, T>,
    layout: Layout,
    face: Face,
    n: usize,
) -> Result<View<'a, T>> {
    let (column, row) = layout.cell(face);
    let start = row * n * view.row_stride() + column * n * view.channels();
    View::new(&view.data()[start..], n, n, view.channels(), view.row_stride())
}

/// Six faces, each with one texel of its neighbours around it; in corners the mean of the three that meet.
fn framed<T: Element>(faces: &[View<'_, T>]) -> Result<Vec<Image>>
where
    crate::image::Pixels: From<Vec<T>>,
{
    let cube = Cube::new(Layout::Strip, DVec3::ZERO)?;
    let (n, channels) = (faces[0].width(), faces[0].channels());
    let last = n as i64;
    let frame = |k: usize| -> Result<Image> {
        let texel = |x: i64, y: i64| -> &[T] {
            if (0..last).contains(&x) && (0..last).contains(&y) {
                return faces[k].pixel(x as usize, y as usize);
            }
            let (face, [x, y]) = neighbour(&cube, Face::ALL[k], [x, y], n);
            faces[face].pixel(x, y)
        };
        let mut data = Vec::with_capacity((n + 2) * (n + 2) * channels);
        for y in -1..=last {
            let near = [y.clamp(0, last - 1), y];
            for x in [-1, last] {
                if x == last && near[0] == y {
                    data.extend_from_slice(faces[k].row(y as usize));
                } else if x == last {
                    for x in 0..last {
                        data.extend_from_slice(texel(x, y));
                    }
                }
                let inner = x.clamp(0, last - 1);
                if near[0] == y {
                    data.extend_from_slice(texel(x, y));
                } else {
                    let three = [texel(inner, near[0]), texel(x, near[0]), texel(inner, y)];
                    data.extend(
                        (0..channels)
                            .map(|c| T::from_f64(three.iter().map(|t| t[c].to_f64()).sum::<f64>() / 3.0)),
                    );
                }
            }
        }
        Image::new(n + 2, n + 2, channels, data)
    };
    (0..6).map(frame).collect()
}
