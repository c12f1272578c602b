//! The crops of one pass, pasted together.

use super::super::{Channels, Layers, Window};

/// A picture of which crops are pasted, bit for bit.
#[derive(Debug)]
pub struct Pasted {
    width: usize,
    layers: Channels,
}

impl Pasted {
    /// A picture of `size`, width and height, with `layers` of zeros.
    pub fn new(size: [u32; 2], layers: &[String]) -> Self {
        let [width, height] = size.map(|side| side as usize);
        let layer = |name: &String| (name.clone(), vec![0.0; width * height]);
        Self { width, layers: layers.iter().map(layer).collect() }
    }

    /// Pastes the layers of `part` into `window`. Layers that the picture lacks are left out.
    ///
    /// # Panics
    /// Where the part is not as large as `window`, or that reaches beyond the picture.
    pub fn add(&mut self, window: Window, part: &Layers) {
        for (name, values) in &part.channels {
            let Some(layer) = self.layers.get_mut(name) else { continue };
            for (pixels, own) in window.rows(self.width) {
                layer[pixels].copy_from_slice(&values[own]);
            }
        }
    }

    /// The layers.
    pub fn finish(self) -> Channels {
        self.layers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_of_a_part_stays() {
        // A signed zero and a subnormal number, which sums would not keep.
        let values = [[-0.0, 1.0], [f32::MIN_POSITIVE / 2.0, -3.0]];
        let names = ["R".to_owned()];
        let mut pasted = Pasted::new([2, 2], &names);
        for (left, column) in values.iter().enumerate() {
            let window = Window { left: left as u32, top: 0, width: 1, height: 2 };
            let part = Layers {
                width: 1,
                height: 2,
                corner: [left as i32, 0],
                display: [2, 2],
                channels: [("R".to_owned(), column.to_vec())].into(),
                attributes: std::collections::BTreeMap::new(),
            };
            pasted.add(window, &part);
        }
        let (name, layer) = pasted.finish().pop_first().unwrap();
        let bits = layer.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let expected = [values[0][0], values[1][0], values[0][1], values[1][1]].map(f32::to_bits);
        assert_eq!((name.as_str(), bits.as_slice()), ("R", &expected[..]));
    }
}
