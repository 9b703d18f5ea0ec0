//! Reading glTF accessors, every range checked.

use super::MAX_ELEMENTS;
use gltf::accessor::{Accessor, DataType};

/// Most elements of an accessor that has no bytes of its own (zeros, but for sparse values).
const MAX_UNBACKED: usize = 1 << 20;

/// The bytes of all buffers of a file.
pub(super) struct Buffers(pub(super) Vec<Vec<u8>>);

/// Elements of one accessor or of the values of a sparse one.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    width: usize,
    count: usize,
    data_type: DataType,
}

impl Elements<'_> {
    fn raw(&self, i: usize, c: usize) -> &[u8] {
        let size = self.data_type.size();
        &self.bytes[i * self.stride + c * size..][..size]
    }

    fn number(&self, i: usize, c: usize, normalized: bool) -> f32 {
        let b = self.raw(i, c);
        let (value, scale) = match self.data_type {
            DataType::I8 => (f32::from(b[0] as i8), 127.0),
            DataType::U8 => (f32::from(b[0]), 255.0),
            DataType::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])), 32_767.0),
            DataType::U16 => (f32::from(u16::from_le_bytes([b[0], b[1]])), 65_535.0),
            DataType::U32 => return self.index(i) as f32,
            DataType::F32 => return f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        };
        if normalized { (value / scale).max(-1.0) } else { value }
    }

    fn index(&self, i: usize) -> u32 {
        self.raw(i, 0).iter().rev().fold(0, |n, &b| n << 8 | u32::from(b))
    }
}

impl Buffers {
    fn view(&self, view: &gltf::buffer::View<'_>) -> Result<&[u8], String> {
        let buffer = self.0.get(view.buffer().index()).ok_or("a view of a buffer that is not there")?;
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| buffer.get(view.offset()..end)).ok_or_else(|| {
            format!(
                "buffer view {} needs bytes {} to {} of a buffer of {}",
                view.index(),
                view.offset(),
                view.offset().saturating_add(view.length()),
                buffer.len()
            )
        })
    }

    /// The bytes of a view, for pictures.
    pub(super) fn bytes(&self, view: &gltf::buffer::View<'_>) -> Result<&[u8], String> {
        self.view(view)
    }

    fn elements(
        &self,
        view: &gltf::buffer::View<'_>,
        offset: usize,
        count: usize,
        data_type: DataType,
        width: usize,
    ) -> Result<Elements<'_>, String> {
        let bytes = self.view(view)?;
        let size = data_type.size() * width;
        let stride = view.stride().unwrap_or(size);
        let end = count.checked_sub(1).map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(size));
        let rest = bytes.get(offset..).filter(|rest| end.is_some_and(|end| end <= rest.len()));
        let Some(bytes) = rest.filter(|_| stride >= size) else {
            let length = bytes.len();
            return Err(format!(
                "{count} elements of {size} bytes, {stride} apart, from byte {offset} of a view of {length}"
            ));
        };
        Ok(Elements { bytes, stride, width, count, data_type })
    }

    fn checked(&self, accessor: &Accessor<'_>) -> Result<Option<Elements<'_>>, String> {
        let (count, width) = (accessor.count(), accessor.dimensions().multiplicity());
        let most = if accessor.view().is_some() { MAX_ELEMENTS } else { MAX_UNBACKED };
        if count > most {
            return Err(format!("an accessor of {count} elements; at most {most} are read"));
        }
        let Some(view) = accessor.view() else { return Ok(None) };
        self.elements(&view, accessor.offset(), count, accessor.data_type(), width).map(Some)
    }

    /// The accessor's numbers, in rows of its own width.
    pub(super) fn floats(&self, accessor: &Accessor<'_>) -> Result<(Vec<f32>, usize), String> {
        let width = accessor.dimensions().multiplicity();
        let normalized = accessor.normalized();
        let mut out = match self.checked(accessor)? {
            None => vec![0.0; accessor.count() * width],
            Some(elements) => (0..elements.count * width)
                .map(|k| elements.number(k / width, k % width, normalized))
                .collect(),
        };
        if let Some(sparse) = accessor.sparse() {
            let count = sparse.count();
            if count > accessor.count() {
                return Err(format!("{count} sparse values for {} elements", accessor.count()));
            }
            let (indices, values) = (sparse.indices(), sparse.values());
            let index_type = match indices.index_type() {
                gltf::accessor::sparse::IndexType::U8 => DataType::U8,
                gltf::accessor::sparse::IndexType::U16 => DataType::U16,
                gltf::accessor::sparse::IndexType::U32 => DataType::U32,
            };
            let places = self.elements(&indices.view(), indices.offset(), count, index_type, 1)?;
            let values =
                self.elements(&values.view(), values.offset(), count, accessor.data_type(), width)?;
            for i in 0..count {
                let place = places.index(i) as usize;
                let row = out
                    .get_mut(place * width..(place + 1) * width)
                    .ok_or_else(|| format!("sparse index {place} of {} elements", accessor.count()))?;
                for (c, value) in row.iter_mut().enumerate() {
                    *value = values.number(i, c, normalized);
                }
            }
        }
        Ok((out, width))
    }

    /// The accessor's rows, which must be this wide.
    pub(super) fn rows<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
        name: &str,
    ) -> Result<Vec<[f32; N]>, String> {
        match self.floats(accessor).map_err(|e| format!("{name}: {e}"))? {
            (data, width) if width == N => Ok(data.as_chunks().0.to_vec()),
            (_, width) => Err(format!("{name}: {width} numbers an element; expected {N}")),
        }
    }

    /// The accessor's whole numbers.
    pub(super) fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>, String> {
        let integer = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if !integer || accessor.dimensions().multiplicity() != 1 || accessor.sparse().is_some() {
            return Err("indices that are not plain unsigned integers".into());
        }
        match self.checked(accessor).map_err(|e| format!("indices: {e}"))? {
            None => Err("indices without a buffer view".into()),
            Some(elements) => {
                debug_assert_eq!(elements.width, 1);
                Ok((0..elements.count).map(|i| elements.index(i)).collect())
            }
        }
    }
}
