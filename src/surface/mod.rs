//! Surfaces: shapes with materials, and the search among them.

mod albedo;
mod diffuse;
mod ggx;
mod glass;
mod material;
mod metal;
mod mirror;
mod plastic;
mod scattered;
mod texture;

use glam::{DVec2, DVec3};

use crate::math::{Aabb, Ray, Span, World, WorldPoint};
use crate::shape::{Bvh, Nearest, Shape, ShapeHit, offset_origin};

pub use ggx::Ggx;
pub use glass::{Glass, dielectric_reflectance};
pub use material::Material;
pub use metal::Metal;
pub use plastic::Plastic;
pub use scattered::{Scattered, TransportMode};
pub use texture::Texture;

/// A shape with what it is made of.
#[derive(Debug, Clone)]
pub struct Surface {
    shape: Shape,
    materials: Vec<Material>,
    light: Option<u32>,
    view: CameraView,
}

/// How rays from the camera see a surface. Rays that were reflected, refracted or scattered, photons and shadow
/// rays meet every surface as it is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum CameraView {
    /// As it is.
    #[default]
    Seen,
    /// Not at all: they pass through it.
    Hidden,
    /// As a hole in the picture: neither it nor what lies behind it is seen.
    Holdout,
    /// As its shadows alone, which are coverage, and its indirect light.
    ShadowCatcher,
}

impl Surface {
    /// A surface. `materials` are indexed by the triangles' slots; shapes other than meshes use
    /// the first. `light` is the index, among the scene's lights, of the one that the surface
    /// emits, on the side its normal points to.
    ///
    /// # Errors
    /// The problem, where a material is missing.
    pub fn new(shape: Shape, materials: Vec<Material>, light: Option<u32>) -> Result<Self, String> {
        let slots = match &shape {
            Shape::Mesh(mesh) => mesh.slot_count(),
            Shape::Sphere(_) | Shape::Quad(_) | Shape::Box(_) | Shape::Plane(_) => 1,
        };
        if materials.len() < slots {
            return Err(format!("{slots} materials belong here, found {}", materials.len()));
        }
        Ok(Self { shape, materials, light, view: CameraView::Seen })
    }

    /// The same surface, which the camera sees so.
    #[must_use]
    pub fn with_view(self, view: CameraView) -> Self {
        Self { view, ..self }
    }

    /// Its shape.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Its materials by slot.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The light that it emits.
    pub fn light(&self) -> Option<u32> {
        self.light
    }

    fn material(&self, primitive: u32) -> &Material {
        let slot = match &self.shape {
            Shape::Mesh(mesh) => mesh.slot(primitive),
            Shape::Sphere(_) | Shape::Quad(_) | Shape::Box(_) | Shape::Plane(_) => 0,
        };
        &self.materials[slot as usize]
    }
}

/// Where a ray meets a surface.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceHit<'a> {
    /// Ray parameter, in multiples of the ray's direction.
    pub t: f64,
    /// The place.
    pub point: WorldPoint,
    /// Bound of the error of each coordinate of `point`, in metres.
    pub error: f64,
    /// Unit geometric normal, outward or as wound; not turned toward the ray.
    pub normal: DVec3,
    /// Unit normal for shading, on the side of `normal`.
    pub shading_normal: DVec3,
    /// Texture coordinates.
    pub uv: DVec2,
    /// What the surface is made of there.
    pub material: &'a Material,
    /// The light that the surface emits on the side its normal points to.
    pub light: Option<u32>,
    /// Index of the surface.
    pub surface: u32,
    /// Index of the triangle of a mesh or of the face of a box, otherwise 0.
    pub primitive: u32,
}

impl SurfaceHit<'_> {
    /// The ray that leaves along `direction` and does not meet the surface again where it starts.
    pub fn leave(&self, direction: DVec3) -> Ray<World> {
        Ray::new(offset_origin(self.point, self.error, self.normal, direction), direction)
    }
}

/// All surfaces of a scene.
#[derive(Debug, Clone)]
pub struct Surfaces {
    surfaces: Vec<Surface>,
    bvh: Bvh,
    /// Those that the camera sees, where it does not see all.
    seen: Option<SeenSurfaces>,
}

/// The surfaces that the camera sees.
#[derive(Debug, Clone)]
struct SeenSurfaces {
    bvh: Bvh,
    /// Their indices among all.
    indices: Vec<u32>,
}

impl SeenSurfaces {
    /// Those among `surfaces`; `None` where all are seen.
    fn new(surfaces: &[Surface]) -> Option<Self> {
        let is_seen = |index: &u32| surfaces[*index as usize].view != CameraView::Hidden;
        let indices: Vec<u32> = (0..surfaces.len() as u32).filter(is_seen).collect();
        let shape = |index: &u32| surfaces[*index as usize].shape.clone();
        (indices.len() < surfaces.len())
            .then(|| Self { bvh: Bvh::new(indices.iter().map(shape).collect()), indices })
    }
}

impl Surfaces {
    /// The surfaces with their BVH; hits name them by their index here.
    pub fn new(surfaces: Vec<Surface>) -> Self {
        let bvh = Bvh::new(surfaces.iter().map(|s| s.shape.clone()).collect());
        Self { seen: SeenSurfaces::new(&surfaces), surfaces, bvh }
    }

    /// The surfaces, by index.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// What all of them are made of.
    pub fn materials(&self) -> impl Iterator<Item = &Material> {
        self.surfaces.iter().flat_map(Surface::materials)
    }

    /// Whether any is a mirror, of glass or rough, so that paths go on there.
    pub fn has_specular(&self) -> bool {
        self.materials().any(|material| material.is_specular() || material.is_rough())
    }

    /// The closest surface that the ray meets inside the open `span`.
    pub fn intersect(&self, ray: &Ray<World>, span: Span) -> Option<SurfaceHit<'_>> {
        self.bvh.intersect(ray, span).map(|hit| self.hit(&hit, hit.shape))
    }

    /// The closest surface that a ray from the camera sees inside the open `span`.
    pub fn intersect_seen(&self, ray: &Ray<World>, span: Span) -> Option<SurfaceHit<'_>> {
        let Some(SeenSurfaces { bvh, indices }) = &self.seen else {
            return self.intersect(ray, span);
        };
        bvh.intersect(ray, span).map(|hit| self.hit(&hit, indices[hit.shape as usize]))
    }

    fn hit(&self, hit: &ShapeHit, index: u32) -> SurfaceHit<'_> {
        let surface = &self.surfaces[index as usize];
        SurfaceHit {
            t: hit.t,
            point: hit.point,
            error: hit.error,
            normal: hit.normal,
            shading_normal: hit.shading_normal,
            uv: hit.uv,
            material: surface.material(hit.primitive),
            light: surface.light,
            surface: index,
            primitive: hit.primitive,
        }
    }

    /// How the camera sees the surface at `hit`.
    pub fn view(&self, hit: &SurfaceHit<'_>) -> CameraView {
        self.surfaces[hit.surface as usize].view
    }

    /// Whether any surface, of glass too, stands in the open `span`.
    pub fn occluded(&self, ray: &Ray<World>, span: Span) -> bool {
        self.bvh.occluded(ray, span)
    }

    /// Whether any surface that the camera sees stands in the open `span` of a ray from or to it.
    pub fn occluded_seen(&self, ray: &Ray<World>, span: Span) -> bool {
        self.seen.as_ref().map_or(&self.bvh, |seen| &seen.bvh).occluded(ray, span)
    }

    /// The closest point of any surface within `max_distance` metres.
    pub fn nearest(&self, point: WorldPoint, max_distance: f64) -> Option<Nearest> {
        self.bvh.nearest(point, max_distance)
    }

    /// The place nearest to `point` on each infinite surface.
    pub fn infinite_feet(&self, point: WorldPoint) -> impl Iterator<Item = (&Surface, WorldPoint)> {
        let feet = self.bvh.infinite_feet(point);
        feet.map(|(index, foot)| (&self.surfaces[index as usize], foot))
    }

    /// The box round the finite surfaces, empty where there are none.
    pub fn bounds(&self) -> Aabb<World> {
        self.bvh.bounds()
    }

    /// Whether any of them may reach into `bounds`: its own box does, or it is infinite and cuts them.
    pub fn reach_into(&self, bounds: &Aabb<World>) -> bool {
        let center = bounds.center();
        let mut boxes = self.surfaces.iter().filter_map(|surface| surface.shape.bounds());
        // A corner lies beyond a plane where the centre is on its other side.
        let is_cut = |foot: WorldPoint| {
            let away = center - foot;
            bounds.corners().iter().any(|corner| (*corner - foot).dot(away) <= 0.0)
        };
        boxes.any(|own| own.overlaps(bounds))
            || self.infinite_feet(center).any(|(_, foot)| is_cut(foot))
    }

    /// About the bytes they take in memory: a mesh in use twice counts once.
    pub fn memory_bytes(&self) -> usize {
        let mut meshes: Vec<_> = self.surfaces.iter().filter_map(|s| s.shape.mesh()).collect();
        meshes.sort_unstable_by_key(|mesh| std::sync::Arc::as_ptr(mesh));
        meshes.dedup_by_key(|mesh| std::sync::Arc::as_ptr(mesh));
        let meshes: usize = meshes.iter().map(|mesh| mesh.memory_bytes()).sum();
        meshes + self.surfaces.len() * 2 * size_of::<Surface>()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.surfaces.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Plane, Sphere};
    use glam::DAffine3;

    #[test]
    fn surfaces_reach_into_boxes_that_they_touch_or_cut() {
        let of = |shape: Shape| {
            Surfaces::new(vec![Surface::new(shape, vec![Material::Black], None).unwrap()])
        };
        let point = |x, y, z| WorldPoint::new(x, y, z);
        let ball = Sphere::new(DVec3::new(3.0, 0.0, 0.0), 1.0, &DAffine3::IDENTITY).unwrap();
        let ball = of(Shape::Sphere(ball));
        let tilted = Plane::new(point(0.0, 0.0, 0.0), DVec3::new(0.6, 0.8, 0.0)).unwrap();
        let tilted = of(Shape::Plane(tilted));
        for (surfaces, low, high, right) in [
            (&ball, [-1.0, -1.0, -1.0], [2.0, 1.0, 1.0], true),
            (&ball, [-1.0, -1.0, -1.0], [1.9, 1.0, 1.0], false),
            (&ball, [-1.0, 1.1, -1.0], [9.0, 2.0, 1.0], false),
            (&tilted, [-1.0, -1.0, -1.0], [1.0, 1.0, 1.0], true),
            // The plane passes the corner (1, -3/4): within reach, and beyond it.
            (&tilted, [1.0, -0.8, 0.0], [2.0, 3.0, 1.0], true),
            (&tilted, [1.0, -0.7, 0.0], [2.0, 3.0, 1.0], false),
            (&tilted, [-9.0, -9.0, 0.0], [-1.0, -1.0, 1.0], false),
            (&Surfaces::new(Vec::new()), [-1.0, -1.0, -1.0], [1.0, 1.0, 1.0], false),
        ] {
            let bounds =
                Aabb::new(WorldPoint::from_xyz(low.into()), WorldPoint::from_xyz(high.into()));
            assert_eq!(surfaces.reach_into(&bounds), right, "{bounds:?}");
        }
    }
}
