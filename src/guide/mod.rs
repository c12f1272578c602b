//! The user's guide, page by page.
#![doc = include_str!(concat!(env!("OUT_DIR"), "/guide/README.md"))]

macro_rules! pages {
    ($($name:ident, $file:literal;)*) => {
        $(
            #[doc = include_str!(concat!(env!("OUT_DIR"), "/guide/", $file))]
            pub mod $name {}
        )*
    };
}

pages! {
    first_steps, "first_steps.md";
    less_noise, "less_noise.md";
    scene, "scene.md";
    keys, "keys.md";
    coming_from, "coming_from.md";
    shots, "shots.md";
    names, "names.md";
    directing, "directing.md";
    studies, "studies.md";
    python, "python.md";
    compositing, "compositing.md";
    motion, "motion.md";
    sequences, "sequences.md";
    farms, "farms.md";
    verification, "verification.md";
    how_it_works, "how_it_works.md";
    limits, "limits.md";
}
