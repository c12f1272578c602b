//! Cryptomatte: which objects a pixel shows, and how much of each (Friedman and Jones 2015, "Fully Automatic ID Mattes with
//! Support for Motion Blur and Transparency"; layers and attributes by Psyop's "Cryptomatte Specification", version 1.2).
//!
//! An object's identifier is a hash of its name. A picture holds it as the float that has the same bits: it stands for
//! itself and is no number to reckon with.
//!
//! The coverages of a pixel are a list of pairs, identifier and coverage, in a slice of [`NUMBERS`]. It fills from the front;
//! places that are free are 0, which no object is.

use std::collections::BTreeMap;

use smallvec::SmallVec;

/// Objects that a picture tells of each pixel.
///
/// Unit: count. Source: the specification, which suggests as many.
const RANKS: usize = 6;

/// Layers of a picture: identifier and coverage of each rank.
///
/// Unit: count. Derivation: from [`RANKS`].
const LAYERS: usize = 2 * RANKS;

/// Objects of which a pixel keeps account while it is rendered.
///
/// Unit: count. Limit: on memory; twice as many as are told, so that one that comes late finds its place.
const CAPACITY: usize = 2 * RANKS;

/// Numbers of a list of coverages.
///
/// Unit: count. Derivation: two of each object that a pixel keeps account of.
pub const NUMBERS: usize = 2 * CAPACITY;

/// What the layers are called, before their numbers.
const NAME: &str = "CryptoObject";

/// What the names of its attributes begin with.
pub const ATTRIBUTES: &str = "cryptomatte/";

/// Bits of the exponent of a float, and how far they lie from the lowest.
const EXPONENT: (u32, u32) = (0xff, 23);

/// The identifier of the object `name`: the hash of the name, of whose exponent as a float 0 and 255 are taken to 1 and 254, so
/// that it is neither subnormal nor infinite nor NaN.
pub fn identifier(name: &str) -> u32 {
    let (mask, shift) = EXPONENT;
    let hash = murmur_hash(name.as_bytes());
    let exponent = (hash >> shift & mask).clamp(1, mask - 1);
    hash & !(mask << shift) | exponent << shift
}

/// Adds `coverage` of the object with this identifier to the `list` of a pixel. Where that has no place for another object, the
/// one with the least coverage is dropped.
pub fn add(list: &mut [f64], identifier: u32, coverage: f64) {
    if identifier == 0 || coverage.is_nan() || coverage <= 0.0 {
        return;
    }
    let identifier = f64::from(identifier);
    let (pairs, _) = list.as_chunks_mut::<2>();
    if let Some([known, sum]) =
        pairs.iter_mut().find(|[known, _]| *known == identifier || *known == 0.0)
    {
        *known = identifier;
        *sum += coverage;
        return;
    }
    let least = pairs.iter_mut().min_by(|a, b| a[1].total_cmp(&b[1]));
    if let Some(least) = least.filter(|least| least[1] < coverage) {
        *least = [identifier, coverage];
    }
}

/// The values of a pixel in [`layers`] by its `list`, whose coverages are shares of `whole`: the objects with most coverage, from the
/// most on, and of several with the same the one with the least identifier first.
pub fn ranks(list: &[f64], whole: f64) -> [f32; LAYERS] {
    let (pairs, _) = list.as_chunks::<2>();
    let seen = pairs.iter().filter(|[known, _]| *known != 0.0);
    let mut seen: SmallVec<[[f64; 2]; CAPACITY]> = seen.copied().collect();
    seen.sort_unstable_by(|a, b| b[1].total_cmp(&a[1]).then(a[0].total_cmp(&b[0])));
    let mut values = [0.0; LAYERS];
    for (pair, [known, sum]) in values.as_chunks_mut::<2>().0.iter_mut().zip(seen) {
        *pair = [f32::from_bits(known as u32), (sum / whole) as f32];
    }
    values
}

/// The names of its layers: two ranks in each four, identifier and coverage of the one, then of the other.
pub fn layers() -> [String; LAYERS] {
    std::array::from_fn(|index| {
        format!("{NAME}{:02}.{}", index / 4, ["R", "G", "B", "A"][index % 4])
    })
}

/// Whether `layer` is the name of one of its layers.
pub fn is_layer(layer: &str) -> bool {
    let group = layer.rsplit_once('.').map_or(layer, |(group, _)| group);
    let number = group.strip_prefix(NAME);
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()))
}

/// The attributes of a picture that shows objects of these `names`: how identifiers are made, and the manifest, in JSON the
/// identifier of each name in hexadecimal.
pub fn attributes<'n>(names: impl IntoIterator<Item = &'n str>) -> [(String, String); 4] {
    let hex = |name: &'n str| (name, format!("{:08x}", identifier(name)));
    let manifest: BTreeMap<&str, String> = names.into_iter().map(hex).collect();
    let manifest = serde_json::to_string(&manifest).unwrap_or_default();
    let attribute = |(name, value): (&str, &str)| (attribute(NAME, name), value.to_owned());
    [
        ("name", NAME),
        ("hash", "MurmurHash3_32"),
        ("conversion", "uint32_to_float32"),
        ("manifest", &manifest),
    ]
    .map(attribute)
}

/// The name of the attribute `key` of the layers called `layer`.
fn attribute(layer: &str, key: &str) -> String {
    let hash = format!("{:08x}", murmur_hash(layer.as_bytes()));
    format!("{ATTRIBUTES}{}/{key}", &hash[..7])
}

/// MurmurHash3 for 32 bits (Appleby, public domain) with a seed of 0.
fn murmur_hash(bytes: &[u8]) -> u32 {
    let scrambled =
        |block: u32| block.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (blocks, tail) = bytes.as_chunks::<4>();
    let mut hash = blocks.iter().fold(0, |hash: u32, block| {
        let mixed = (hash ^ scrambled(u32::from_le_bytes(*block))).rotate_left(13);
        mixed.wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let rest = tail.iter().rev().fold(0, |rest, byte| rest << 8 | u32::from(*byte));
    hash ^= scrambled(rest);
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The names that the tests of Psyop's own decoder for Nuke have, with their identifiers as floats.
    #[test]
    fn identifiers_are_those_of_the_specification() {
        for (name, expected) in [
            ("hello", 6.070_562_710_24e-17_f64),
            ("cube", -4.084_619_125_19e15),
            ("sphere", 2.790_186_043_83e15),
            ("plane", 3.665_576_175_93e-11),
            ("равнина", -1.319_263_121_24e-25),
            ("mädchen", 6.236_129_821_16e25),
        ] {
            let found = f64::from(f32::from_bits(identifier(name)));
            assert!((found / expected - 1.0).abs() < 1e-11, "{name}: {found:e}");
        }
        // Of the manifests of its sample pictures, and of the specification.
        for (name, expected) in [
            ("bunny", 0x1385_1a76),
            ("bush", 0xf763_d090),
            ("default", 0x42c9_679f),
            ("leftAsset", 0xce40_6a47),
            ("flowerA.flowerA_petal1.:2261", 0x00af_91ae),
        ] {
            assert_eq!(identifier(name), expected, "{name}");
        }
    }

    #[test]
    fn attributes_have_the_keys_of_other_programs() {
        // Those that the tests of Blender have.
        assert_eq!(attribute("ViewLayer.CryptoMaterial", "key"), "cryptomatte/c7dbf5e/key");
        assert_eq!(attribute("𝖚𝖓𝖎𝖈𝖔𝖉𝖊.CryptoMaterial", "𝓴𝓮𝔂"), "cryptomatte/b990b65/𝓴𝓮𝔂");
        let [name, .., manifest] = attributes(["bunny", "a \"b\"\\ü\n", "bunny"]);
        // Readers that know no long names of attributes take 31 bytes.
        assert!(name.0.starts_with("cryptomatte/") && name.0.ends_with("/name"));
        assert!(name.1 == "CryptoObject" && manifest.0.len() <= 31);
        let manifest: BTreeMap<String, String> = serde_json::from_str(&manifest.1).unwrap();
        assert_eq!(manifest.len(), 2);
        for (name, hex) in manifest {
            assert_eq!(u32::from_str_radix(&hex, 16), Ok(identifier(&name)), "{name}");
        }
    }

    #[test]
    fn layers_hold_two_ranks_each() {
        let names = layers();
        assert_eq!(names[..3], ["CryptoObject00.R", "CryptoObject00.G", "CryptoObject00.B"]);
        assert_eq!(names[11], "CryptoObject02.A");
        assert!(names.iter().all(|name| is_layer(name)));
        for other in ["R", "CryptoObject.R", "CryptoObjects00.R", "media.R"] {
            assert!(!is_layer(other), "{other}");
        }
    }

    #[test]
    fn objects_are_ranked_by_coverage() {
        let mut list = [0.0; NUMBERS];
        for (id, coverage) in [(7, 0.25), (9, 1.0), (7, 0.5), (3, 0.75), (0, 9.0), (5, 0.0)] {
            add(&mut list, id, coverage);
        }
        let values = ranks(&list, 4.0);
        let expected = [9, 3, 7].map(f32::from_bits);
        assert_eq!([values[0], values[2], values[4]], expected);
        assert_eq!([values[1], values[3], values[5]], [0.25, 0.1875, 0.1875]);
        assert_eq!(values[6..], [0.0; 6]);
    }

    proptest! {
        #[test]
        fn every_name_is_a_plain_float(name in ".*") {
            prop_assert!(f32::from_bits(identifier(&name)).is_normal());
        }

        /// A list holds the sums of few objects exactly, and of many drops small ones alone.
        #[test]
        fn lists_keep_what_covers_most(
            few in prop::collection::vec((1_u32..13, 0_u32..9), 0..40),
            many in prop::collection::vec(14_u32..2000, 0..80),
        ) {
            let mut list = [0.0; NUMBERS];
            let mut sums = BTreeMap::<u32, f64>::new();
            for (id, eighths) in few {
                let coverage = f64::from(eighths) / 8.0;
                add(&mut list, id, coverage);
                *sums.entry(id).or_default() += coverage;
            }
            let kept: f64 = list.iter().skip(1).step_by(2).sum();
            prop_assert_eq!(kept, sums.values().sum::<f64>());
            add(&mut list, 13, 100.0);
            for id in many {
                add(&mut list, id, 0.125);
            }
            let values = ranks(&list, 1.0);
            prop_assert_eq!((values[0].to_bits(), values[1]), (13, 100.0));
            prop_assert!(values.chunks(2).zip(values.chunks(2).skip(1)).all(|(a, b)| a[1] >= b[1]));
        }
    }
}
