//! Values of header attributes: text in the program, numbers, vectors and matrices in the file.
//!
//! A text that is a number, or an array of 2, 3 or 16 numbers, as JSON writes them, is stored as what it tells, and reads back
//! as the same text; all other texts are stored as they are.

use exr::meta::attribute::{Chromaticities, Matrix4x4, Rational};
use exr::prelude::{AttributeValue, LayerAttributes, Text, Vec2};
use serde::Serialize;
use serde_json::Value;

/// Attributes of the OpenEXR standard that are written where they are given.
pub(super) const STANDARD: [&str; 3] = ["worldToCamera", "worldToNDC", "framesPerSecond"];

/// The primaries and white of Rec.709 (ITU-R BT.709-6, table 1), which pictures have.
///
/// Unit: none. Source: ITU-R BT.709-6.
pub(super) const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.3, 0.6),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.329),
};

/// The value that stands for `text` in a file.
pub(super) fn typed(text: &str) -> AttributeValue {
    let value = serde_json::from_str(text).unwrap_or(Value::Null);
    let kinds = [whole, single, double];
    let found = kinds.iter().filter_map(|kind| kind(&value));
    // A kind that would change a digit is none.
    found
        .into_iter()
        .find(|known| told(known).is_some_and(|back| back == text))
        .unwrap_or_else(|| AttributeValue::Text(Text::from_slice_unchecked(text.as_bytes())))
}

/// The value of the attribute `name` that stands for `text` in a file.
pub(super) fn named(name: &str, text: &str) -> AttributeValue {
    let standard = match name {
        "framesPerSecond" => rational(text).map(AttributeValue::Rational),
        "worldToCamera" | "worldToNDC" => matrix(text).map(AttributeValue::Matrix4x4),
        _ => None,
    };
    standard.unwrap_or_else(|| typed(text))
}

/// The text of a `value`; `None` where it is none that [`typed`] makes.
pub(super) fn told(value: &AttributeValue) -> Option<String> {
    /// Whole numbers up to here are exact as f64.
    const EXACT: f64 = (1_u64 << f64::MANTISSA_DIGITS) as f64;
    Some(match value {
        AttributeValue::Text(text) => String::from_utf8_lossy(text.bytes()).into_owned(),
        AttributeValue::I32(number) => number.to_string(),
        AttributeValue::F32(number) => in_json(number),
        AttributeValue::F64(number) if number.fract() == 0.0 && number.abs() < EXACT => {
            (*number as i64).to_string()
        }
        AttributeValue::F64(number) => in_json(number),
        AttributeValue::IntVec2(Vec2(x, y)) => in_json(&[x, y]),
        AttributeValue::FloatVec2(Vec2(x, y)) => in_json(&[x, y]),
        AttributeValue::IntVec3((x, y, z)) => in_json(&[x, y, z]),
        AttributeValue::FloatVec3((x, y, z)) => in_json(&[x, y, z]),
        AttributeValue::Matrix4x4(rows) => in_json(&rows[..]),
        AttributeValue::Rational((number, of)) => format!("{number}/{of}"),
        _ => return None,
    })
}

/// Sets the attribute `name` of the [`STANDARD`] ones to `text` in `header`. `None` where the text is of another kind.
pub(super) fn set_standard(header: &mut LayerAttributes, name: &str, text: &str) -> Option<()> {
    match name {
        "framesPerSecond" => header.frames_per_second = Some(rational(text)?),
        "worldToCamera" => header.world_to_camera = Some(matrix(text)?),
        "worldToNDC" => header.world_to_normalized_device = Some(matrix(text)?),
        _ => return None,
    }
    Some(())
}

fn matrix(text: &str) -> Option<Matrix4x4> {
    serde_json::from_str::<Vec<f32>>(text).ok()?.try_into().ok()
}

fn rational(text: &str) -> Option<Rational> {
    let (number, of) = text.split_once('/')?;
    Some((number.parse().ok()?, of.parse().ok().filter(|of| *of > 0)?))
}

fn whole(value: &Value) -> Option<AttributeValue> {
    let number = |value: &Value| value.as_i64().and_then(|number| i32::try_from(number).ok());
    Some(match value.as_array().map(Vec::as_slice) {
        None => AttributeValue::I32(number(value)?),
        Some([x, y]) => AttributeValue::IntVec2(Vec2(number(x)?, number(y)?)),
        Some([x, y, z]) => AttributeValue::IntVec3((number(x)?, number(y)?, number(z)?)),
        Some(_) => return None,
    })
}

fn single(value: &Value) -> Option<AttributeValue> {
    let number = |value: &Value| value.as_f64().map(|number| number as f32);
    Some(match value.as_array().map(Vec::as_slice) {
        None => AttributeValue::F32(number(value)?),
        Some([x, y]) => AttributeValue::FloatVec2(Vec2(number(x)?, number(y)?)),
        Some([x, y, z]) => AttributeValue::FloatVec3((number(x)?, number(y)?, number(z)?)),
        Some(all) => {
            let rows: Vec<f32> = all.iter().map(number).collect::<Option<_>>()?;
            AttributeValue::Matrix4x4(rows.try_into().ok()?)
        }
    })
}

fn double(value: &Value) -> Option<AttributeValue> {
    value.as_f64().map(AttributeValue::F64)
}

/// `value` in JSON; an f32 has the digits that tell it from others.
pub(super) fn in_json<T: Serialize + ?Sized>(value: &T) -> String {
    // Not by way of a `Value`, which would give an f32 the digits of an f64.
    serde_json::to_string(value).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde_json::json;

    #[test]
    fn numbers_are_typed() {
        use AttributeValue as V;
        let text = |text: &str| V::Text(Text::from_slice_unchecked(text.as_bytes()));
        let rows: [f32; 16] = std::array::from_fn(|i| i as f32 / 3.0);
        let cases = [
            ("16", V::I32(16)),
            ("-2147483648", V::I32(i32::MIN)),
            ("4294967296", V::F64(4_294_967_296.0)),
            ("18446744073709551615", text("18446744073709551615")),
            ("0.5", V::F32(0.5)),
            ("0.1", V::F32(0.1)),
            ("0.123456789012", V::F64(0.123456789012)),
            ("[960,540]", V::IntVec2(Vec2(960, 540))),
            ("[0.5,0.25]", V::FloatVec2(Vec2(0.5, 0.25))),
            ("[1.5,2.0,3.0]", V::FloatVec3((1.5, 2.0, 3.0))),
            ("[960, 540]", text("[960, 540]")),
            ("[1,2,3,4]", text("[1,2,3,4]")),
            ("true", text("true")),
            ("1.0", V::F32(1.0)),
            ("01", text("01")),
            ("3/8", text("3/8")),
            ("", text("")),
        ];
        for (given, expected) in cases {
            assert_eq!(typed(given), expected, "{given}");
            assert_eq!(told(&expected).unwrap(), given);
        }
        assert_eq!(typed(&in_json(&rows)), V::Matrix4x4(rows));
        assert_eq!(rational("24000/1001"), Some((24000, 1001)));
        assert_eq!(rational("24/0"), None);
    }

    proptest! {
        #[test]
        fn every_text_comes_back(text in "[-0-9.eE,\\[\\]]{0,9}|.{0,9}") {
            prop_assert_eq!(told(&typed(&text)), Some(text));
        }

        #[test]
        fn every_number_comes_back(whole in any::<u64>(), fraction in any::<f64>()) {
            for text in [json!(whole).to_string(), json!(fraction).to_string()] {
                prop_assert_eq!(told(&typed(&text)), Some(text));
            }
        }
    }
}
