//! The order of attributes in an EXR header.
//!
//! The exr crate keeps custom attributes in a hash map with a random seed, so that it writes the
//! same header in another order every time. The order has no meaning in the format ("OpenEXR File
//! Layout", section "Header"), and the length stays, so sorting them leaves every offset right.

/// Bytes before the first attribute: magic number and version.
const PREAMBLE: usize = 8;

/// Sorts the attributes of the only header in a single-part EXR file by name. `None` where the
/// bytes are no such file.
pub(super) fn sort_attributes(file: &mut [u8]) -> Option<()> {
    let mut attributes = Vec::new();
    let mut rest = file.get(PREAMBLE..)?;
    while *rest.first()? != 0 {
        let size = attribute_size(rest)?;
        let (attribute, after) = rest.split_at_checked(size)?;
        attributes.push(attribute);
        rest = after;
    }
    attributes.sort_by_key(|attribute| c_string(attribute));
    let sorted = attributes.concat();
    file[PREAMBLE..PREAMBLE + sorted.len()].copy_from_slice(&sorted);
    Some(())
}

/// Bytes of the attribute in front: name, type, both ended by 0, length of the value, value.
fn attribute_size(bytes: &[u8]) -> Option<usize> {
    let name = c_string(bytes)?.len() + 1;
    let kind = c_string(bytes.get(name..)?)?.len() + 1;
    let value = name + kind + 4;
    let length = bytes.get(name + kind..value)?.try_into().ok().map(i32::from_le_bytes)?;
    value.checked_add(usize::try_from(length).ok()?)
}

fn c_string(bytes: &[u8]) -> Option<&[u8]> {
    bytes.iter().position(|&b| b == 0).map(|end| &bytes[..end])
}
