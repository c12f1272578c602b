//! `volumes/PAPER.md`: fogbow's figures beside those of Anson, Sundstedt, Gutierrez and Chalmers
//! 2006, "Efficient Selective Rendering of Participating Media".

use super::Result;
use super::markdown::{NONE, figure, table};
use super::paper::Row;
use super::record::{About, about, rows, source};

/// What the paper reports of a scene.
struct Published {
    scene: &'static str,
    /// Table 1: average error in %, by MSE and by VDP.
    average: [&'static str; 2],
    /// Table 2: pixels in error in %, by MSE and by VDP.
    pixels: [&'static str; 2],
    /// Table 3: right answers of 24, chi-square and p, without the gold standard in view and with.
    answers: [[&'static str; 3]; 2],
}

const PAPER: [Published; 4] = [
    Published {
        scene: "Balls A",
        average: ["0.13", "0.27"],
        pixels: ["3.23", "0.35"],
        answers: [["16", "2.67", ".10"], ["8", "2.67", ".10"]],
    },
    Published {
        scene: "Balls B",
        average: ["0.10", "0.61"],
        pixels: ["3.04", "0.29"],
        answers: [["12", "0", "1.00"], ["17", "4.17", ".04"]],
    },
    Published {
        scene: "Lucy",
        average: ["0.45", "0.76"],
        pixels: ["8.51", "0.57"],
        answers: [["16", "2.67", ".10"], ["20", "10.67", ".00"]],
    },
    Published {
        scene: "Road",
        average: ["0.87", "0.19"],
        pixels: ["50.33", "0.04"],
        answers: [["21", "13.5", ".00"], ["22", "16.67", ".00"]],
    },
];

/// Figure 5 gives no number a scene.
const FIGURE_5: &str = "5.2 to 10.3 over its four scenes";

const WAYS: [&str; 2] = ["xs-paper", "xs-scattering"];

/// The page.
pub fn beside(json: &str) -> Result<String> {
    let rows: Vec<Row> = rows(json)?;
    Ok(format!(
        "# fogbow beside the paper\n\
         Anson, Sundstedt, Gutierrez and Chalmers 2006, \"Efficient Selective Rendering of \
         Participating Media\", scene by scene. `xs-paper` directs as they do: X from transmittance, X \
         and S in equal parts, rays alone. `xs-scattering` is fogbow's own: X from scattered light, with \
         gather radius and march step directed as well. The gold standard has 16 rays in every pixel, \
         the longer side 512 pixels, as in the paper; figures are means over seeds, intervals at \
         95 %.\n\n\
         Ratios of run times, errors in 8-bit codes and counts of answers are of the same kind in both \
         and can be compared in their order of magnitude. Single values cannot: the scenes follow the \
         paper's but are not its own, fogbow's error is grain in nearly every pixel where the paper's is \
         mostly in few, renderer and machine differ, and which VDP the paper used is unknown.\n\n\
         ## Figure 5: run times\n{}\n\
         ## Table 1: average error\n\
         In percent. By MSE, of 8-bit sRGB codes against the largest (which mean the paper took is not \
         said). By VDP, the average chance of seeing a difference in a pixel: by the model of Daly 1993 \
         (VDP), and counted only where the pictures differ, as the public program HDR VDP does since its \
         version 1.5 of 2006 (localised).\n\n{}\n\
         ## Table 2: pixels in error\n\
         In percent. By MSE, pixels in which an 8-bit code differs; by VDP, pixels with a chance above \
         75 %.\n\n{}\n\
         ## Table 3: people\n\
         Right answers of 24 people in each condition: without a reference, which of two pictures is \
         worse; with it, which is most similar to the gold standard. 12 is chance. `fogbow trial` makes \
         the same experiment; nobody has sat it with fogbow's pictures yet.\n\n{}\n\
         The paper's figures stand in its Figure 5 and Tables 1 to 3; fogbow's are in \
         [paper.json](../tests/bench/results/paper.json).\n\n{}",
        run_times(&rows),
        errors(
            &rows,
            |row| [row.code_mse_percent, row.vdp_mean_percent, row.vdp_localized_mean_percent],
            |paper| paper.average
        ),
        errors(
            &rows,
            |row| [
                row.code_pixels_percent,
                row.vdp_visible_percent,
                row.vdp_localized_visible_percent
            ],
            |paper| paper.pixels
        ),
        people(),
        with_note(&about(json)?)
    ))
}

/// Where the figures come from, and what else holds for them.
fn with_note(about: &About) -> String {
    let note = if about.note.is_empty() { String::new() } else { format!("\n{}\n", about.note) };
    source(about) + &note
}

fn find<'a>(rows: &'a [Row], scene: &str, way: &str) -> Option<&'a Row> {
    rows.iter().find(|row| row.scene == scene && row.way == way)
}

fn run_times(rows: &[Row]) -> String {
    let lines = PAPER.iter().map(|paper| {
        let seconds = |way| figure(find(rows, paper.scene, way).map(|row| row.seconds), 3);
        let times = |way| {
            let speed_up = find(rows, paper.scene, way).and_then(|row| row.speed_up);
            speed_up.map_or_else(|| NONE.into(), |speed_up| speed_up.told())
        };
        let mut cells = vec![paper.scene.to_owned(), seconds("gold")];
        for way in WAYS {
            cells.extend([seconds(way), times(way)]);
        }
        cells.push(FIGURE_5.into());
        cells
    });
    table(
        &[
            "scene",
            "gold, s",
            "`xs-paper`, s",
            "times faster",
            "`xs-scattering`, s",
            "times faster",
            "the paper, times faster",
        ],
        lines,
    )
}

fn errors(
    rows: &[Row],
    own: fn(&Row) -> [Option<f64>; 3],
    papers: fn(&Published) -> [&'static str; 2],
) -> String {
    let lines = PAPER.iter().map(|paper| {
        let of = |way, which: usize| {
            let value = find(rows, paper.scene, way).and_then(|row| own(row)[which]);
            value.map_or_else(|| NONE.into(), |value| figure(value, 3))
        };
        let [mse, vdp] = papers(paper);
        let [a, b] = WAYS;
        let own = [of(a, 0), of(b, 0), mse.into(), of(a, 1), of(b, 1), of(a, 2), of(b, 2)];
        [paper.scene.to_owned()].into_iter().chain(own).chain([vdp.into()]).collect()
    });
    table(
        &[
            "scene",
            "MSE: `xs-paper`",
            "`xs-scattering`",
            "**the paper**",
            "VDP: `xs-paper`",
            "`xs-scattering`",
            "localised: `xs-paper`",
            "`xs-scattering`",
            "**the paper**",
        ],
        lines,
    )
}

fn people() -> String {
    let lines = PAPER.iter().map(|paper| {
        let cells = paper.answers.as_flattened().iter().map(|cell| (*cell).to_owned());
        [paper.scene.to_owned()].into_iter().chain(cells).collect()
    });
    table(
        &[
            "scene",
            "the paper, no reference: right",
            "chi-square",
            "p",
            "with reference: right",
            "chi-square",
            "p",
        ],
        lines,
    )
}
