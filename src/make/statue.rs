//! A winged figure in a long robe that holds up a torch, on a pedestal.

use glam::{DVec2, DVec3};

use super::noise::{Turbulence, smoothstep};

/// Half of the box round the statue, across and from front to back, in units of its height.
pub(super) const HALF_WIDTH: f64 = 0.5;
pub(super) const HALF_DEPTH: f64 = 0.22;

/// The top of the pedestal, on which the robe ends.
const FLOOR: f64 = 0.13;

/// Where the robe ends above, at the waist.
const WAIST: f64 = 0.5;

/// A rounded rod that changes its radius: from where, how thick there, to where, how thick there.
type Rod = (DVec3, f64, DVec3, f64);

const fn rod(from: [f64; 3], thick: f64, to: [f64; 3], thin: f64) -> Rod {
    (DVec3::from_array(from), thick, DVec3::from_array(to), thin)
}

/// Chest, shoulders, neck and arms.
const BODY: [Rod; 10] = [
    rod([0.0, 0.49, 0.0], 0.048, [0.0, 0.59, 0.004], 0.06),
    rod([-0.056, 0.638, 0.0], 0.03, [0.056, 0.642, 0.0], 0.03),
    rod([0.0, 0.65, 0.0], 0.024, [0.004, 0.705, 0.006], 0.018),
    // The arm with the torch, and its sleeve.
    rod([0.07, 0.645, 0.0], 0.027, [0.128, 0.672, 0.03], 0.019),
    rod([0.128, 0.672, 0.03], 0.018, [0.14, 0.775, 0.05], 0.011),
    rod([0.1, 0.655, 0.015], 0.03, [0.122, 0.58, 0.02], 0.01),
    // The arm that gathers the robe, and what hangs from its hand.
    rod([-0.07, 0.64, 0.0], 0.027, [-0.115, 0.565, 0.025], 0.02),
    rod([-0.115, 0.565, 0.025], 0.02, [-0.07, 0.505, 0.08], 0.012),
    rod([-0.07, 0.505, 0.078], 0.014, [-0.052, 0.4, 0.066], 0.014),
    rod([-0.052, 0.4, 0.066], 0.014, [-0.03, 0.15, 0.07], 0.04),
];

/// Hands, shaft, bowl and flame.
const TORCH: [Rod; 5] = [
    rod([0.14, 0.775, 0.05], 0.016, [0.14, 0.79, 0.052], 0.014),
    rod([0.139, 0.715, 0.047], 0.006, [0.144, 0.85, 0.056], 0.009),
    rod([0.144, 0.85, 0.056], 0.01, [0.145, 0.875, 0.057], 0.022),
    rod([0.145, 0.89, 0.057], 0.021, [0.148, 0.93, 0.055], 0.015),
    rod([0.148, 0.93, 0.055], 0.015, [0.156, 0.985, 0.06], 0.003),
];

/// Feathers in the long row of each wing.
const FEATHERS: u32 = 12;

/// The statue.
pub(super) struct Statue {
    folds: Turbulence,
    wing: Vec<Feather>,
}

/// One feather of the wing on the side of positive x: a flat blade from `root` along the unit vector
/// `along`.
struct Feather {
    root: DVec3,
    along: DVec3,
    length: f64,
    width: f64,
}

impl Statue {
    /// The statue whose robe falls as `seed` says.
    pub(super) fn new(seed: u64) -> Self {
        Self { folds: Turbulence::new(seed, 0), wing: wing() }
    }

    /// Distance from `p` to the surface, negative inside; near the surface right to a factor of
    /// about 2.
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        let body = BODY.iter().fold(self.robe(p), |d, r| blend(d, to_rod(p, r), 0.022));
        let torch = TORCH.iter().map(|r| to_rod(p, r)).fold(f64::MAX, f64::min);
        let figure = blend(blend(body, head(p), 0.012), torch, 0.006);
        blend(figure, self.wings(p), 0.014).min(pedestal(p))
    }

    /// The skirt: a bell in folds, wide at the feet.
    fn robe(&self, p: DVec3) -> f64 {
        let fall = ((WAIST - p.y) / (WAIST - FLOOR)).clamp(0.0, 1.0);
        // The weight rests on one leg.
        let axis = DVec2::new(0.014 * (std::f64::consts::PI * fall).sin(), 0.0);
        let across = (DVec2::new(p.x, p.z) - axis) * DVec2::new(1.0, 1.12);
        let (angle, out) = (across.y.atan2(across.x), across.length());
        let bell = 0.047 + 0.036 * smoothstep(0.0, 0.45, fall) + 0.026 * fall * fall;
        // Noise on a ring closes where the angle starts anew.
        let ring = DVec3::new(angle.cos(), 0.55 * p.y, angle.sin());
        let wander = self.folds.fbm(ring * 1.3, 2.0);
        let pleats = (13.0 * angle + 7.0 * wander + 3.0 * fall).sin();
        let broad = self.folds.fbm(ring * 2.4 + 5.0, 2.0);
        let cloth = (0.0065 * pleats + 0.014 * broad) * smoothstep(0.02, 0.6, fall);
        let side = 0.6 * (out - bell - cloth);
        side.max(FLOOR - 0.01 - p.y).max(p.y - WAIST - 0.02)
    }

    /// Both wings: the bones along the upper edge and the feathers that hang from them.
    fn wings(&self, p: DVec3) -> f64 {
        let p = DVec3::new(p.x.abs(), p.y, p.z);
        let bones = (0..8).map(|i| {
            let [from, to] = [i, i + 1].map(|i| bone(f64::from(i) / 8.0));
            to_rod(p, &(from, 0.017, to, 0.015))
        });
        let feathers = self.wing.iter().map(|f| f.distance(p));
        let bones = bones.fold(f64::MAX, f64::min);
        blend(bones, feathers.fold(f64::MAX, f64::min), 0.01)
    }
}

impl Feather {
    fn distance(&self, p: DVec3) -> f64 {
        /// How much thinner than wide.
        const FLATNESS: f64 = 2.4;
        let q = p - self.root;
        let along = q.dot(self.along);
        let share = (along / self.length).clamp(0.0, 1.0);
        let rest = q - self.along * (share * self.length);
        let width = self.width * (0.75 + 0.4 * share) * (1.0 - share.powi(5)).sqrt();
        let flat = DVec3::new(rest.x, rest.y, rest.z * FLATNESS);
        (flat.length() - width.max(0.2 * self.width)) / FLATNESS.sqrt()
    }
}

/// The upper edge of the wing on the side of positive x, from the shoulder blade at 0 over the
/// wrist to its end at 1.
fn bone(t: f64) -> DVec3 {
    const EDGE: [DVec3; 4] = [
        DVec3::new(0.03, 0.58, -0.055),
        DVec3::new(0.07, 0.8, -0.1),
        DVec3::new(0.14, 0.93, -0.12),
        DVec3::new(0.2, 0.8, -0.14),
    ];
    let s = 1.0 - t; // a cubic Bézier curve
    EDGE[0] * (s * s * s)
        + EDGE[1] * (3.0 * s * s * t)
        + EDGE[2] * (3.0 * s * t * t)
        + EDGE[3] * (t * t * t)
}

/// A row of long feathers, and before it two of shorter ones that cover their roots.
fn wing() -> Vec<Feather> {
    let row = |count: u32, reach: f64, width: f64, forward: f64| {
        (0..count).map(move |i| {
            let t = (f64::from(i) + 0.5) / f64::from(count);
            let lean = 0.06 + 0.4 * t;
            let along = DVec3::new(lean.sin(), -lean.cos(), -0.12).normalize();
            let length = reach * (0.2 + 0.28 * smoothstep(0.0, 0.85, t));
            Feather { root: bone(t) + DVec3::Z * forward, along, length, width }
        })
    };
    let rows = [
        row(FEATHERS, 1.0, 0.019, 0.0),
        row(FEATHERS - 1, 0.58, 0.017, 0.009),
        row(FEATHERS - 2, 0.28, 0.015, 0.016),
    ];
    rows.into_iter().flatten().collect()
}

fn head(p: DVec3) -> f64 {
    let face = to_ellipsoid(p, DVec3::new(0.004, 0.735, 0.012), DVec3::new(0.029, 0.039, 0.032));
    let nose = to_rod(p, &rod([0.004, 0.742, 0.04], 0.004, [0.004, 0.728, 0.047], 0.006));
    let hair = to_ellipsoid(p, DVec3::new(0.004, 0.747, -0.006), DVec3::new(0.034, 0.037, 0.033));
    let knot = p.distance(DVec3::new(0.004, 0.758, -0.045)) - 0.016;
    let wreath = {
        let q = p - DVec3::new(0.004, 0.757, 0.002);
        let tilted = DVec3::new(q.x, q.y + 0.35 * q.z, q.z);
        let ring = DVec2::new(tilted.x, tilted.z).length() - 0.0325;
        DVec2::new(ring, tilted.y).length() - 0.005
    };
    blend(blend(face, nose, 0.006), blend(hair, knot, 0.008).min(wreath), 0.005)
}

/// Round, on a square slab, with a moulding at each end.
fn pedestal(p: DVec3) -> f64 {
    let out = DVec2::new(p.x, p.z).length();
    let disc = |radius: f64, from: f64, to: f64, round: f64| {
        let half = 0.5 * (to - from);
        let q = DVec2::new(out - radius + round, (p.y - from - half).abs() - half + round);
        q.max(DVec2::ZERO).length() + q.max_element().min(0.0) - round
    };
    let slab = {
        let q = (p - DVec3::Y * 0.018).abs() - DVec3::new(0.15, 0.018, 0.15) + 0.004;
        q.max(DVec3::ZERO).length() + q.max_element().min(0.0) - 0.004
    };
    let drum = disc(0.118, 0.03, 0.12, 0.004);
    let foot = disc(0.134, 0.036, 0.054, 0.009);
    let top = disc(0.134, 0.108, FLOOR, 0.007);
    slab.min(blend(drum, foot.min(top), 0.012))
}

fn to_rod(p: DVec3, &(from, thick, to, thin): &Rod) -> f64 {
    let axis = to - from;
    let t = ((p - from).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
    p.distance(from + axis * t) - (thick + (thin - thick) * t)
}

fn to_ellipsoid(p: DVec3, center: DVec3, radii: DVec3) -> f64 {
    let q = p - center;
    let scaled = (q / radii).length();
    scaled * (scaled - 1.0) / (q / (radii * radii)).length().max(1e-9)
}

/// The union of two solids, filleted over a distance of about `fillet` where they meet.
fn blend(a: f64, b: f64, fillet: f64) -> f64 {
    let overlap = (fillet - (a - b).abs()).max(0.0) / fillet;
    a.min(b) - 0.25 * fillet * overlap * overlap
}
