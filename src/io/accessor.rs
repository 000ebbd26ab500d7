//! Reads glTF accessors: positions and indices out of buffers.
//!
//! The crate's own iterators panic where an accessor reaches beyond its buffer, where a stride is
//! shorter than an element, or where a type is unknown. Here each number is checked instead.

use gltf::json::accessor::{
    Accessor, ComponentType, GenericComponentType, IndexComponentType, Type,
};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root, buffer};

use super::views::{Views, size};

/// Elements of one kind that lie in a buffer one after the other.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    pub(super) component: ComponentType,
    pub(super) components: usize,
    pub(super) is_normalized: bool,
}

pub(super) struct Accessors<'a> {
    root: &'a Root,
    views: Views<'a>,
}

impl<'a> Accessors<'a> {
    pub(super) fn new(root: &'a Root, views: Views<'a>) -> Self {
        Self { root, views }
    }

    pub(super) fn views(&mut self) -> &mut Views<'a> {
        &mut self.views
    }

    /// The positions that an accessor holds: floating-point, or integers as the extension
    /// `KHR_mesh_quantization` allows.
    pub(super) fn positions(&mut self, index: Index<Accessor>) -> Result<Vec<[f64; 3]>, String> {
        let read = |accessors: &mut Self| {
            let (accessor, component) = accessors.find(index, Type::Vec3)?;
            if component == ComponentType::U32 {
                return Err("positions can't be 32-bit integers".into());
            }
            let layout = Layout { component, components: 3, is_normalized: accessor.normalized };
            accessors.elements(accessor, layout, |element| {
                [0, 1, 2].map(|axis| number(element, axis, layout))
            })
        };
        read(self).map_err(at_accessor(index))
    }

    /// The vertex indices that an accessor holds.
    pub(super) fn indices(&mut self, index: Index<Accessor>) -> Result<Vec<u32>, String> {
        let read = |accessors: &mut Self| {
            let (accessor, component) = accessors.find(index, Type::Scalar)?;
            if !is_index(component) {
                return Err("indices must be unsigned integers".into());
            }
            let layout = Layout { component, components: 1, is_normalized: false };
            accessors.elements(accessor, layout, |element| number(element, 0, layout) as u32)
        };
        read(self).map_err(at_accessor(index))
    }

    fn find(
        &self,
        index: Index<Accessor>,
        expected: Type,
    ) -> Result<(&'a Accessor, ComponentType), String> {
        let root = self.root;
        let accessor = root.get(index).ok_or("it does not exist")?;
        let Checked::Valid(GenericComponentType(component)) = accessor.component_type else {
            return Err("its component type is unknown".into());
        };
        if !matches!(accessor.type_, Checked::Valid(found) if found == expected) {
            return Err(format!("its type should be {expected:?}"));
        }
        Ok((accessor, component))
    }

    fn elements<T: Clone>(
        &mut self,
        accessor: &Accessor,
        layout: Layout,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, String> {
        let count = size(accessor.count.0)?;
        let mut elements = match accessor.buffer_view {
            Some(view) => {
                let offset = size(accessor.byte_offset.unwrap_or_default().0)?;
                self.strided(view, offset, count, layout)?.map(&decode).collect()
            }
            // Zeros, which the file need not hold.
            None if count > self.views.file_length() => {
                return Err(format!(
                    "it announces {count} elements, but the file has only {} bytes",
                    self.views.file_length()
                ));
            }
            None => vec![decode(&[]); count],
        };
        if let Some(sparse) = &accessor.sparse {
            let Checked::Valid(IndexComponentType(component)) = sparse.indices.component_type
            else {
                return Err("the type of its sparse indices is unknown".into());
            };
            let index_layout = Layout { component, components: 1, is_normalized: false };
            let changes = size(sparse.count.0)?;
            let offset = size(sparse.indices.byte_offset.0)?;
            let targets: Vec<usize> = self
                .strided(sparse.indices.buffer_view, offset, changes, index_layout)?
                .map(|element| number(element, 0, index_layout) as usize)
                .collect();
            let offset = size(sparse.values.byte_offset.0)?;
            let values = self.strided(sparse.values.buffer_view, offset, changes, layout)?;
            for (target, value) in targets.into_iter().zip(values.map(&decode)) {
                *elements.get_mut(target).ok_or_else(|| {
                    format!("it has {count} elements, but changes number {target}")
                })? = value;
            }
        }
        Ok(elements)
    }

    /// The bytes of `count` elements; each is at least as long as the layout says.
    fn strided(
        &mut self,
        view: Index<buffer::View>,
        offset: usize,
        count: usize,
        layout: Layout,
    ) -> Result<impl Iterator<Item = &[u8]>, String> {
        let element_length = layout.component.size() * layout.components;
        let stride = match self.views.stride(view)? {
            None | Some(0) => element_length,
            Some(stride) if stride < element_length => {
                return Err(format!(
                    "buffer view {view}: a stride of {stride} bytes is too short for elements of \
                     {element_length}"
                ));
            }
            Some(stride) => stride,
        };
        let bytes = self.views.get(view)?;
        let length = bytes.len();
        let needed = match count.checked_sub(1) {
            None => Some(offset),
            Some(others) => others
                .checked_mul(stride)
                .and_then(|length| length.checked_add(element_length)?.checked_add(offset)),
        };
        if needed.is_none_or(|needed| needed > length) {
            return Err(format!(
                "its {count} elements reach beyond the {length} bytes of buffer view {view}"
            ));
        }
        Ok(bytes.get(offset..).unwrap_or_default().chunks(stride).take(count))
    }
}

fn at_accessor(index: Index<Accessor>) -> impl Fn(String) -> String {
    move |reason| format!("accessor {index}: {reason}")
}

fn is_index(component: ComponentType) -> bool {
    matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
}

/// A component of an element. What is not there is 0, as in an accessor without a buffer view.
pub(super) fn number(element: &[u8], index: usize, layout: Layout) -> f64 {
    let at = index * layout.component.size();
    let bytes = element.get(at..).unwrap_or_default();
    let mut four = [0; 4];
    for (target, byte) in four.iter_mut().zip(bytes) {
        *target = *byte;
    }
    let [low, high, ..] = four;
    // Normalised integers stand for -1 to 1 or 0 to 1.
    let (value, greatest) = match layout.component {
        ComponentType::I8 => (f64::from(low as i8), f64::from(i8::MAX)),
        ComponentType::U8 => (f64::from(low), f64::from(u8::MAX)),
        ComponentType::I16 => (f64::from(i16::from_le_bytes([low, high])), f64::from(i16::MAX)),
        ComponentType::U16 => (f64::from(u16::from_le_bytes([low, high])), f64::from(u16::MAX)),
        ComponentType::U32 => (f64::from(u32::from_le_bytes(four)), f64::from(u32::MAX)),
        ComponentType::F32 => return f64::from(f32::from_le_bytes(four)),
    };
    if layout.is_normalized { (value / greatest).max(-1.0) } else { value }
}
