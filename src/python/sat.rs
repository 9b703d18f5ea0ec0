//! Summed-area tables.

use super::convert::{FloatArray, ImageArg, array, work};
use crate::sat::{SummedAreaTable, Table};
use crate::wrap::Wrap;
use pyo3::prelude::*;

/// The table of one image.
#[pyclass(name = "SummedAreaTable", frozen, module = "multum._multum")]
struct PySummedAreaTable(SummedAreaTable);

#[pymethods]
impl PySummedAreaTable {
    #[new]
    fn new(
        py: Python<'_>,
        image: &Bound<'_, PyAny>,
        wrap: (String, String),
        border: Vec<f64>,
    ) -> PyResult<Self> {
        let image = ImageArg::new("image", image)?;
        let view = image.view()?;
        let wrap = [Wrap::parse("wrap", &wrap.0)?, Wrap::parse("wrap", &wrap.1)?];
        Ok(Self(work(py, None, || SummedAreaTable::new(view, wrap, Some(&border)))?))
    }

    /// Sums or means of boxes (..., 4).
    fn boxes<'py>(
        &self,
        py: Python<'py>,
        boxes: &Bound<'py, PyAny>,
        mean: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let boxes = FloatArray::new("boxes", boxes, &[4], "(..., 4)")?;
        let mut shape = boxes.leading(1).to_vec();
        shape.push(self.0.channels());
        let numbers = boxes.to_f64()?;
        let values = work(py, None, || {
            let (boxes, _) = numbers.as_chunks::<4>();
            let mut values = vec![0.0; boxes.len() * self.0.channels()];
            self.0.boxes_uv(boxes, mean, &mut values)?;
            Ok(values)
        })?;
        array(py, values, &shape)
    }

    /// A copy of the entries.
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let shape = [self.0.height() + 1, self.0.width() + 1, self.0.channels()];
        match self.0.table() {
            Table::U32(entries) => array(py, entries.clone(), &shape),
            Table::U64(entries) => array(py, entries.clone(), &shape),
            Table::F64(entries) => array(py, entries.clone(), &shape),
        }
    }

    /// What was taken off float texels before they were summed, per channel.
    fn offset<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.0.offset().to_vec(), &[self.0.channels()])
    }

    /// Wrap modes for u and v.
    fn wrap(&self) -> (&'static str, &'static str) {
        let [u, v] = self.0.wrap();
        (u.name(), v.name())
    }
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PySummedAreaTable>()
}
