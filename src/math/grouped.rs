//! Light told apart by the group of its emitters, or by the order of its scattering.

use std::array;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub};

use glam::BVec3;

use super::grouped_f32::{GroupedF32, SingleGroup};
use super::{Group, GroupParts, MAX_GROUPS, MOST_NUMBERS, ORDERS, Rgb, Spectrum};

/// A colour and, where it is light, the parts of it that each group of emitters has, or each [order](ORDERS) of scattering; a
/// coefficient has none. All decisions look at the whole, which is what [`Rgb`] would be, bit by bit. Sums and products keep the
/// parts such that they add up to it, to rounding. A coefficient that is added to light counts as light of the first group, or of
/// order 0. Where parts are orders, the weight of a path that was scattered has them too.
#[derive(Debug, Clone, Copy, Default)]
pub struct GroupedRgb {
    whole: Rgb,
    parts: Option<[Rgb; MAX_GROUPS]>,
}

impl GroupedRgb {
    /// The parts of light of the first group alone.
    fn first(whole: Rgb) -> [Rgb; MAX_GROUPS] {
        let mut parts = [Rgb::ZERO; MAX_GROUPS];
        parts[0] = whole;
        parts
    }

    /// The parts of the product of the weight of a path and light at its end, whose orders add up.
    fn product_by_order(
        weight: &[Rgb; MAX_GROUPS],
        light: &[Rgb; MAX_GROUPS],
    ) -> [Rgb; MAX_GROUPS] {
        let mut parts = [Rgb::ZERO; MAX_GROUPS];
        for (order, weight) in weight[..ORDERS].iter().enumerate() {
            for (more, light) in light[..ORDERS].iter().enumerate() {
                parts[(order + more).min(ORDERS - 1)] += *weight * *light;
            }
        }
        parts
    }

    /// The same with `f` applied to the whole and each part.
    fn each(self, f: impl Fn(Rgb) -> Rgb) -> Self {
        Self { whole: f(self.whole), parts: self.parts.map(|parts| parts.map(&f)) }
    }

    /// `f`, a sum or difference, of both.
    fn both(self, other: Self, f: impl Fn(Rgb, Rgb) -> Rgb) -> Self {
        let parts = (self.parts.is_some() || other.parts.is_some()).then(|| {
            let [a, b] =
                [self, other].map(|light| light.parts.unwrap_or_else(|| Self::first(light.whole)));
            array::from_fn(|group| f(a[group], b[group]))
        });
        Self { whole: f(self.whole, other.whole), parts }
    }
}

impl PartialEq for GroupedRgb {
    /// Whether the wholes are equal.
    fn eq(&self, other: &Self) -> bool {
        self.whole == other.whole
    }
}

impl Add for GroupedRgb {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.both(other, Add::add)
    }
}

impl Sub for GroupedRgb {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.both(other, Sub::sub)
    }
}

impl Neg for GroupedRgb {
    type Output = Self;
    fn neg(self) -> Self {
        self.each(Neg::neg)
    }
}

impl Mul for GroupedRgb {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let scaled = |parts: [Rgb; MAX_GROUPS], by: Rgb| parts.map(|part| part * by);
        let parts = match (&self.parts, &other.parts) {
            (None, None) => None,
            (Some(parts), None) => Some(scaled(*parts, other.whole)),
            (None, Some(parts)) => Some(scaled(*parts, self.whole)),
            // Only orders make light of both.
            (Some(weight), Some(light)) => Some(Self::product_by_order(weight, light)),
        };
        Self { whole: self.whole * other.whole, parts }
    }
}

impl Mul<f64> for GroupedRgb {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self.each(|part| part * factor)
    }
}

impl Div<f64> for GroupedRgb {
    type Output = Self;
    fn div(self, divisor: f64) -> Self {
        self.each(|part| part / divisor)
    }
}

impl AddAssign for GroupedRgb {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl MulAssign for GroupedRgb {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl MulAssign<f64> for GroupedRgb {
    fn mul_assign(&mut self, factor: f64) {
        *self = *self * factor;
    }
}

impl DivAssign<f64> for GroupedRgb {
    fn div_assign(&mut self, divisor: f64) {
        *self = *self / divisor;
    }
}

impl Sum for GroupedRgb {
    fn sum<I: Iterator<Item = Self>>(values: I) -> Self {
        values.fold(Self::ZERO, Add::add)
    }
}

impl Spectrum for GroupedRgb {
    const CHANNELS: usize = 3;
    const NUMBERS: usize = MOST_NUMBERS;
    const ZERO: Self = Self { whole: Rgb::ZERO, parts: None };
    const ONE: Self = Self { whole: Rgb::ONE, parts: None };

    type Stored = GroupedF32;
    type Single = SingleGroup;
    type F32 = GroupedF32;

    fn from_rgb(color: Rgb) -> Self {
        Self { whole: color, parts: None }
    }

    fn of_group(color: Rgb, group: Group) -> Self {
        let mut parts = [Rgb::ZERO; MAX_GROUPS];
        parts[usize::from(group.0)] = color;
        Self { whole: color, parts: Some(parts) }
    }

    fn in_group(self, group: Group) -> Self {
        if self.parts.is_some() { self } else { Self::of_group(self.whole, group) }
    }

    fn raised(self, orders: u8) -> Self {
        self * Self::of_group(Rgb::ONE, Group(orders))
    }

    fn parts(self) -> Option<GroupParts> {
        let parts = self.parts.unwrap_or_else(|| Self::first(self.whole));
        Some(parts.map(|part| part.as_vec3().to_array()))
    }

    fn rgb(self) -> Rgb {
        self.whole
    }

    fn channel(self, index: usize) -> f64 {
        self.whole[index]
    }

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let whole = Spectrum::map(self.whole, f);
        let parts = self.parts.map(|parts| {
            let is_nothing = self.whole.cmpeq(Rgb::ZERO);
            let scale = Rgb::select(is_nothing, Rgb::ZERO, whole / self.whole);
            let mut parts = parts.map(|part| part * scale);
            parts[0] += Rgb::select(is_nothing, whole, Rgb::ZERO);
            parts
        });
        Self { whole, parts }
    }

    fn to_f32(self) -> GroupedF32 {
        let mut numbers = [0.0; MOST_NUMBERS];
        let parts = self.parts.iter().flatten();
        for (to, from) in numbers.chunks_exact_mut(3).zip([self.whole].iter().chain(parts)) {
            to.copy_from_slice(&from.as_vec3().to_array());
        }
        GroupedF32(numbers)
    }

    fn to_f64(value: GroupedF32) -> Self {
        Self::from_numbers(|index| f64::from(value.0[index]))
    }

    fn pack(value: GroupedF32) -> GroupedF32 {
        value
    }

    fn unpack(stored: GroupedF32) -> GroupedF32 {
        stored
    }

    fn pack_single(value: GroupedF32) -> SingleGroup {
        let ([whole, parts @ ..], _) = value.0.as_chunks::<3>() else {
            return SingleGroup { light: [0.0; 3], group: Group(0) };
        };
        let is_lit = |part: &[f32; 3]| *part != [0.0; 3];
        let group = parts.iter().position(is_lit).unwrap_or(0) as u8;
        SingleGroup { light: *whole, group: Group(group) }
    }

    fn unpack_single(single: SingleGroup) -> GroupedF32 {
        let mut numbers = [0.0; MOST_NUMBERS];
        for first in [0, 3 * (1 + usize::from(single.group.0))] {
            numbers[first..first + 3].copy_from_slice(&single.light);
        }
        GroupedF32(numbers)
    }

    fn number(self, index: usize) -> f64 {
        let (part, channel) = (index / 3, index % 3);
        match part.checked_sub(1) {
            None => self.whole[channel],
            Some(group) => self.parts.map_or(0.0, |parts| parts[group][channel]),
        }
    }

    fn from_numbers(f: impl Fn(usize) -> f64) -> Self {
        let color = |first: usize| Rgb::new(f(first), f(first + 1), f(first + 2));
        let parts: [Rgb; MAX_GROUPS] = array::from_fn(|group| color(3 * (1 + group)));
        let is_light = parts.iter().any(|part| *part != Rgb::ZERO);
        Self { whole: color(0), parts: is_light.then_some(parts) }
    }

    fn from_numbers_f32(f: impl Fn(usize) -> f32) -> GroupedF32 {
        GroupedF32(array::from_fn(f))
    }

    fn number_f32(value: GroupedF32, index: usize) -> f32 {
        value.0[index]
    }

    fn element_sum(self) -> f64 {
        self.whole.element_sum()
    }

    fn max_element(self) -> f64 {
        self.whole.max_element()
    }

    fn nonzero(self) -> BVec3 {
        self.whole.nonzero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn color() -> impl Strategy<Value = Rgb> {
        prop::array::uniform3(-1.0..1.2f64).prop_map(Rgb::from)
    }

    /// The parts of `light` in f64.
    fn sum(light: GroupedRgb) -> Rgb {
        light.parts.unwrap_or_else(|| GroupedRgb::first(light.whole)).into_iter().sum()
    }

    /// One step of a computation with light, by the number `kind`, in any spectrum.
    fn step<S: Spectrum>(light: S, kind: u8, color: Rgb, group: Group) -> S {
        let coefficient = S::from_rgb(color);
        let factor = color.x;
        match kind {
            0 => light + S::of_group(color, group),
            1 => light * coefficient,
            2 => coefficient.exp() * light,
            3 => light - S::of_group(color, group) * 0.25,
            4 => light * factor,
            5 => light / (2.0 + factor),
            6 => light.not_negative(),
            7 => -light,
            8 => S::to_f64(S::unpack(S::pack(light.to_f32()))),
            9 => S::to_f64(light.to_f32() * 0.3 + coefficient.in_group(group).to_f32() / 0.7),
            10 => [light, S::ZERO, S::of_group(color, group)].into_iter().sum(),
            11 => S::from_numbers(|index| light.number(index)),
            12 => light + coefficient * S::ZERO,
            _ => light + S::of_group(color, group) * coefficient,
        }
    }

    proptest! {
        #[test]
        fn the_whole_is_that_of_a_colour_and_the_parts_add_up_to_it(
            steps in prop::collection::vec((0u8..14, color(), 0u8..MAX_GROUPS as u8), 1..24)
        ) {
            let (mut light, mut right) = (GroupedRgb::of_group(Rgb::ONE, Group(3)), Rgb::ONE);
            // The largest number on the way bounds what differences leave of roundings.
            let mut largest = 1.0f64;
            for (kind, color, group) in steps {
                light = step(light, kind, color, Group(group));
                right = step(right, kind, color, Group(group));
                prop_assert_eq!(light.whole.to_array().map(f64::to_bits), right.to_array().map(f64::to_bits));
                let parts = light.parts.unwrap_or_else(|| GroupedRgb::first(light.whole));
                let of_parts = parts.map(|part| part.abs().max_element()).into_iter().fold(0.0, f64::max);
                largest = largest.max(of_parts) * color.abs().max_element().max(1.0).exp();
                let off = (sum(light) - right).abs().max_element();
                prop_assert!(off <= 1e-5 * largest, "{off} of {largest} after {kind}");
                prop_assert_eq!(light.element_sum().to_bits(), right.element_sum().to_bits());
                prop_assert_eq!(light.max_element().to_bits(), right.max_element().to_bits());
                prop_assert_eq!(light.nonzero(), right.nonzero());
            }
        }

        #[test]
        fn groups_are_scaled_alike_and_kept_apart(a in color(), b in color(), by in color()) {
            let light = GroupedRgb::of_group(a, Group(2)) + GroupedRgb::of_group(b, Group(5));
            let parts = (light * GroupedRgb::from_rgb(by)).parts.unwrap();
            for (group, part) in parts.into_iter().enumerate() {
                let right = match group { 2 => a * by, 5 => b * by, _ => Rgb::ZERO };
                prop_assert_eq!(part, right);
            }
        }

        #[test]
        fn a_photon_keeps_its_group(power in color(), group in 0u8..MAX_GROUPS as u8) {
            let power = GroupedRgb::of_group(power, Group(group)).to_f32();
            prop_assert_eq!(GroupedRgb::unpack_single(GroupedRgb::pack_single(power)), power);
        }
    }

    /// The parts of `light` by order.
    fn orders(light: GroupedRgb) -> [f64; ORDERS] {
        array::from_fn(|order| light.parts.unwrap()[order].x)
    }

    #[test]
    fn orders_of_a_path_and_its_light_add_up() {
        let weight = GroupedRgb::splat(0.5);
        let [once, twice] = [1, 2].map(|count| weight.raised(1) * weight.raised(count - 1));
        assert_eq!([once, twice].map(orders), [[0.0, 0.25, 0.0], [0.0, 0.0, 0.25]]);
        let emitted = GroupedRgb::of_group(Rgb::ONE, Group(0));
        let found = emitted * 4.0 + emitted.raised(1) * 2.0 + emitted.raised(2);
        assert_eq!(orders(found), [4.0, 2.0, 1.0]);
        assert_eq!(orders(found * weight), [2.0, 1.0, 0.5]);
        assert_eq!(orders(once * found), [0.0, 1.0, 0.75]);
        assert_eq!(orders(found.raised(1)), orders(found * GroupedRgb::ONE.raised(1)));
        assert_eq!(orders(found.raised(2).raised(1)), [0.0, 0.0, 7.0]);
        assert_eq!(found.raised(1).whole, found.whole);
        assert_eq!(orders((once * found).in_group(Group(0))), [0.0, 1.0, 0.75]);
        let photon = (emitted * 0.3).raised(1).to_f32();
        assert_eq!(GroupedRgb::unpack_single(GroupedRgb::pack_single(photon)), photon);
    }

    #[test]
    fn coefficients_have_no_parts() {
        let (zero, half) = (GroupedRgb::ZERO, GroupedRgb::splat(0.5));
        assert!((half * half + zero).exp().parts.is_none());
        assert!(GroupedRgb::to_f64(half.to_f32()).parts.is_none());
        let light = GroupedRgb::of_group(Rgb::ONE, Group(7));
        assert_eq!((zero + light).parts, light.parts);
        assert_eq!(
            half.parts(),
            Some({
                let mut parts = [[0.0; 3]; MAX_GROUPS];
                parts[0] = [0.5; 3];
                parts
            })
        );
    }
}
