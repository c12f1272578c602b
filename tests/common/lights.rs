//! One of each kind of light.

use fogbow::light::{
    BeamPicture, Environment, Falloff, Light, MeshLight, PointLight, QuadLight, SpotLight, Sun,
};
use fogbow::math::{Rgb, WorldPoint};
use glam::DVec3;

pub(crate) const WHITE: Rgb = Rgb::ONE;

fn picture_texels() -> Vec<[f32; 3]> {
    let mut texels: Vec<[f32; 3]> =
        (0..32).map(|i| [i as f32 % 5.0, i as f32 % 3.0, i as f32 % 2.0]).collect();
    texels[11] = [40.0, 30.0, 20.0];
    texels
}

/// A tetrahedron seen from outside, about 1 m across, round `center`.
pub(crate) fn tetrahedron(center: DVec3) -> Vec<[DVec3; 3]> {
    let p = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
        .map(|(x, y, z)| center + 0.4 * DVec3::new(f64::from(x), f64::from(y), f64::from(z)));
    vec![[p[0], p[1], p[2]], [p[0], p[3], p[1]], [p[0], p[2], p[3]], [p[1], p[3], p[2]]]
}

pub(crate) fn quad_corners(center: DVec3, u: DVec3, v: DVec3) -> Vec<[DVec3; 3]> {
    let [a, b, c, d] =
        [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(s, t)| center + u * s + v * t);
    vec![[a, b, c], [a, c, d]]
}

pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) light: Light,
    /// Its surface, where it has one.
    pub(crate) triangles: Vec<[DVec3; 3]>,
}

/// One row a light and way of falling off; all shine on the origin, `scale` m is the distance of
/// the finite ones.
pub(crate) fn all(scale: f64) -> Vec<Row> {
    let place = DVec3::new(1.0, 3.0, -2.0) * scale;
    let at = WorldPoint::from_xyz(place);
    let spot = |angle, falloff| SpotLight::new(at, -place, WHITE, angle, falloff).unwrap();
    let (u, v) = (DVec3::new(1.5, 0.0, 0.3) * scale, DVec3::new(0.2, -0.3, -1.0) * scale);
    let (u, v) = if u.cross(v).dot(-place) > 0.0 { (u, v) } else { (v, u) };
    let mesh: Vec<[DVec3; 3]> =
        tetrahedron(DVec3::ZERO).iter().map(|t| t.map(|p| place + p * scale)).collect();
    let picture = BeamPicture { width: 8, height: 4, texels: picture_texels(), up: DVec3::Y };
    let row = |name, light| Row { name, light, triangles: Vec::new() };
    let environment = |rotation| Environment::picture(8, 4, picture_texels(), WHITE, rotation);
    // With an edge, a black stop, and more below and above than the stops say.
    let gradient = [
        (-50.0, Rgb::new(0.1, 0.2, 0.3)),
        (-5.0, Rgb::ZERO),
        (-5.0, Rgb::splat(0.4)),
        (20.0, Rgb::new(2.0, 1.5, 1.0)),
        (80.0, Rgb::new(0.3, 0.3, 0.6)),
    ];
    let down = DVec3::new(0.3, -1.0, 0.2);
    vec![
        row("point", Light::Point(PointLight::new(at, WHITE).unwrap())),
        row("spot", Light::Spot(spot(40.0, Falloff::Smooth { start: 10.0 }))),
        row("hard spot", Light::Spot(spot(5.0, Falloff::Smooth { start: 5.0 }))),
        row("cosine spot", Light::Spot(spot(90.0, Falloff::Cosine { exponent: 8.0 }))),
        row(
            "projector",
            Light::Spot(spot(25.0, Falloff::Smooth { start: 20.0 }).with_picture(picture).unwrap()),
        ),
        row("direction", Light::Sun(Sun::new(down, WHITE, 0.0).unwrap())),
        row("sun", Light::Sun(Sun::new(down, WHITE, 0.53).unwrap())),
        row("wide sun", Light::Sun(Sun::new(down, WHITE, 60.0).unwrap())),
        Row {
            name: "quad",
            light: Light::Quad(QuadLight::new(at, u, v, WHITE).unwrap()),
            triangles: quad_corners(place, u, v),
        },
        Row {
            name: "mesh",
            light: Light::Mesh(MeshLight::new(mesh.clone(), WHITE).unwrap()),
            triangles: mesh,
        },
        row("constant", Light::Environment(Environment::constant(WHITE).unwrap())),
        row("gradient", Light::Environment(Environment::gradient(&gradient).unwrap())),
        row("picture", Light::Environment(environment(0.0).unwrap())),
        row("turned picture", Light::Environment(environment(77.0).unwrap())),
    ]
}
