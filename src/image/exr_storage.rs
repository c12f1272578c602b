//! Which layers of a picture a file holds, and with how many bits.
//!
//! A layer that has one value everywhere stands in the header with that value, so that a file says all and holds no planes of
//! the same number. Colours may be stored as half floats, where those hold them.

use std::collections::{BTreeMap, BTreeSet};

use half::f16;

use super::cryptomatte;
use super::exr_attribute::in_json;

/// What the attribute of a layer of one value begins with, before the name of the layer.
const CONSTANT: &str = "fogbow:constant.";

/// The layers that every program looks for. They are kept, and so are those of passes, which were asked for.
const KEPT: [&str; 5] = ["R", "G", "B", "A", "Z"];

/// How a picture is stored.
#[derive(Clone, Copy)]
pub(super) struct Storage<'a> {
    /// Whether layers of one value are left out.
    pub(super) leaves_out: bool,
    /// Whether the layer of a name is stored as half floats, where those hold it.
    pub(super) half: &'a dyn Fn(&str) -> bool,
}

impl Storage<'_> {
    /// All layers, as they are.
    pub(super) const FULL: Self = Self { leaves_out: false, half: &|_| false };
}

/// Whether the layer of that name is a colour or coverage. Identifiers of objects are none, and have all of their bits.
pub(super) fn is_color(name: &str) -> bool {
    let channel = name.rsplit('.').next().unwrap_or(name);
    (["R", "G", "B"].contains(&channel) || name == "A") && !cryptomatte::is_layer(name)
}

/// Takes out of `layers` those that have one value everywhere and may be left out. Returns an attribute for each.
pub(super) fn leave_out_constants(layers: &mut Vec<(&str, &[f32])>) -> Vec<(String, String)> {
    let mut left_out = Vec::new();
    layers.retain(|(name, values)| {
        let first = values[0];
        let is_constant = values.iter().all(|value| value.to_bits() == first.to_bits());
        let leaves = is_constant && !KEPT.contains(name) && !name.contains('.');
        if leaves {
            left_out.push((format!("{CONSTANT}{name}"), in_json(&first)));
        }
        !leaves
    });
    left_out
}

/// Takes the layers of one value out of the attributes of a header: name and value of each.
pub(super) fn take_constants(attributes: &mut BTreeMap<String, String>) -> Vec<(String, f32)> {
    let mut constants = Vec::new();
    attributes.retain(|attribute, value| {
        let name = attribute.strip_prefix(CONSTANT).filter(|name| !name.is_empty());
        let value = value.parse().ok().filter(|value: &f32| value.is_finite());
        let Some((name, value)) = name.zip(value) else { return true };
        constants.push((name.to_owned(), value));
        false
    });
    constants
}

/// The names of those `layers` that are stored as half floats: of colours that are `wanted`, with all channels of a colour alike.
/// A colour that half floats cannot hold, since it is too bright, or so dark that they lose digits, is not among them.
pub(super) fn half_layers<'a>(
    layers: &[(&'a str, &[f32])],
    wanted: &dyn Fn(&str) -> bool,
) -> BTreeSet<&'a str> {
    let group = |name: &'a str| name.rsplit_once('.').map_or("", |(group, _)| group);
    let colors = layers.iter().filter(|(name, _)| is_color(name));
    // For each colour its largest size, of RGB and of A apart, and whether all of it is wanted.
    let mut groups: BTreeMap<&str, (f32, bool)> = BTreeMap::new();
    for (name, values) in colors.clone() {
        let (largest, all) = groups.entry(group(name)).or_insert((0.0, true));
        *largest = values.iter().fold(*largest, |largest, value| largest.max(value.abs()));
        *all &= wanted(name);
    }
    let (brightest, darkest) = (f16::MAX.to_f32(), f16::MIN_POSITIVE.to_f32());
    let holds = |(largest, all): &(f32, bool)| {
        *all && *largest <= brightest && (*largest == 0.0 || *largest >= darkest)
    };
    let names = colors.map(|(name, _)| *name);
    names.filter(|name| groups.get(group(name)).is_some_and(holds)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_of_one_value_are_left_out_and_come_back() {
        let (same, other) = ([0.1_f32; 2], [0.0_f32, -0.0]);
        let mut layers: Vec<(&str, &[f32])> =
            vec![("R", &same), ("Z", &same), ("xs", &same), ("step", &other), ("media.R", &same)];
        let left_out = leave_out_constants(&mut layers);
        let names: Vec<_> = layers.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["R", "Z", "step", "media.R"]);
        let mut attributes: BTreeMap<String, String> = left_out.into_iter().collect();
        attributes.insert("fogbow:seed".into(), "1".into());
        attributes.insert("fogbow:constant.".into(), "1".into());
        attributes.insert("fogbow:constant.a".into(), "one".into());
        assert_eq!(take_constants(&mut attributes), [("xs".to_owned(), 0.1)]);
        assert_eq!(attributes.len(), 3);
    }

    #[test]
    fn colours_that_half_floats_hold_are_halved() {
        let (one, bright, dark, black) = ([1.0_f32], [65_505.0_f32], [1e-6_f32], [0.0_f32]);
        let layers: [(&str, &[f32]); 9] = [
            ("R", &one),
            ("A", &one),
            ("Z", &one),
            ("a.R", &one),
            ("a.G", &bright),
            ("b.B", &dark),
            ("c.G", &black),
            ("normal.X", &one),
            ("CryptoObject00.R", &one),
        ];
        let halves =
            |wanted: &dyn Fn(&str) -> bool| half_layers(&layers, wanted).into_iter().collect();
        let found: Vec<_> = halves(&|_| true);
        assert_eq!(found, ["A", "R", "c.G"]);
        let found: Vec<_> = halves(&|name| name != "A");
        assert_eq!(found, ["c.G"]);
    }
}
