//! Counts and the chi-square test.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::answers::{Answer, Condition};

/// How often the gold standard was recognised for a scene in one condition, and the p-value of these counts
/// under guessing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// The scene's name.
    pub scene: String,
    /// How it was shown.
    pub condition: Condition,
    /// Answers.
    pub answers: u64,
    /// Those that chose the gold standard.
    pub right: u64,
    /// Those that chose the directed picture.
    pub wrong: u64,
    /// Chi-square of both counts against half of the answers each: the sum of
    /// (observed - expected)² / expected, without a correction for continuity.
    pub chi_square: f64,
    /// The probability of a chi-square at least as large, with one degree of freedom, if all answers are
    /// guesses.
    pub p: f64,
}

impl Tally {
    fn new(scene: &str, condition: Condition, right: u64, wrong: u64) -> Self {
        let expected = (right + wrong) as f64 / 2.0;
        let off = |observed: u64| (observed as f64 - expected).powi(2) / expected;
        let chi_square = off(right) + off(wrong);
        // One degree of freedom is above 0, so that there is such a distribution.
        let p = ChiSquared::new(1.0).map_or(f64::NAN, |law| law.sf(chi_square));
        let (scene, answers) = (scene.to_owned(), right + wrong);
        Self { scene, condition, answers, right, wrong, chi_square, p }
    }
}

/// The answers counted by scene and condition, in alphabetical order.
pub fn tally(answers: &[Answer]) -> Vec<Tally> {
    let mut counts: BTreeMap<(Condition, &str), [u64; 2]> = BTreeMap::new();
    for answer in answers {
        let count = counts.entry((answer.condition, &answer.scene)).or_default();
        count[usize::from(!answer.is_right())] += 1;
    }
    let counts = counts.into_iter();
    counts
        .map(|((condition, scene), [right, wrong])| Tally::new(scene, condition, right, wrong))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Out of 24: the counts of Table 3 in Anson et al. 2006, and p by tables of the normal law.
    #[test]
    fn the_papers_counts_give_its_chi_squares() {
        for (right, chi_square, p) in [
            (16, 2.67, 0.102_47),
            (17, 4.17, 0.041_23),
            (20, 10.67, 0.001_091),
            (21, 13.5, 0.000_238_6),
            (22, 16.67, 0.000_044_56),
            (12, 0.0, 1.0),
            (8, 2.67, 0.102_47),
        ] {
            let result = Tally::new("road", Condition::Successive, right, 24 - right);
            assert!((result.chi_square - chi_square).abs() < 0.005, "{result:?}");
            assert!((result.p - p).abs() < 1e-3 * p, "{result:?}");
        }
    }

    #[test]
    fn answers_are_counted_by_scene_and_condition() {
        use super::super::answers::Side::{First, Left, Right, Second};
        let answer = |scene: &str, condition, gold, chosen| Answer {
            participant: "ann".into(),
            scene: scene.into(),
            condition,
            gold,
            chosen,
            seconds: None,
            time: String::new(),
        };
        let tallies = tally(&[
            answer("road", Condition::Reference, Left, Right),
            answer("lucy", Condition::Successive, First, First),
            answer("road", Condition::Successive, Second, Second),
            answer("road", Condition::Successive, Second, First),
        ]);
        let counts: Vec<_> = tallies
            .iter()
            .map(|t| (t.scene.as_str(), t.condition.name(), t.right, t.wrong))
            .collect();
        let expected = [
            ("lucy", "successive", 1, 0),
            ("road", "successive", 1, 1),
            ("road", "reference", 0, 1),
        ];
        assert_eq!(counts, expected);
    }
}
