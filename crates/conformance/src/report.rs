//! What was compared with what, and how it came out, as a page of Markdown.

use crate::matrix::{Pair, Way};
use crate::references::{Measured, Reference};
use std::fmt::Write as _;

/// A reference, and what came of it: `None` where its picture is absent.
pub type Checked = (Reference, Option<Measured>);

/// The whole report, and whether everything agrees.
pub fn page(ways: &[Way], pairs: &[Pair], references: &[Checked]) -> (String, bool) {
    let mut page = format!("# Conformance of Rutilant {}\n", env!("CARGO_PKG_VERSION"));
    // Writing to a string does not fail.
    let _ = agreement(&mut page, ways, pairs);
    let _ = others(&mut page, references);
    let agrees = pairs.iter().all(Pair::agrees)
        && references.iter().all(|(r, measured)| !r.same || measured.is_none_or(|m| m.agrees()));
    (page, agrees)
}

fn agreement(page: &mut String, ways: &[Way], pairs: &[Pair]) -> std::fmt::Result {
    let mut scenes: Vec<&str> = pairs.iter().map(|pair| pair.scene).collect();
    scenes.dedup();
    let [width, height] = ways.first().map_or([0; 2], |way| way.settings.size);
    writeln!(page, "\n## Every way of finding light gives the same picture\n")?;
    writeln!(
        page,
        "{} scenes, {} ways, {} pairs of pictures of {width} × {height} pixels.",
        scenes.len(),
        ways.len(),
        pairs.len()
    )?;
    writeln!(
        page,
        "Scores are differences in standard errors.\n\
         p is the probability that chance alone makes any of all pairs differ as much; below 0.01 the two disagree.\n\
         Mean z² is 1 where the scatter is what the variances say, and less with \"sobol\", whose variances are upper bounds.\n"
    )?;
    writeln!(page, "| way | seed | samples per pixel |\n|---|---|---|")?;
    for Way { name, settings } in ways {
        writeln!(page, "| {name} | {} | {} |", settings.seed, settings.spp)?;
    }

    writeln!(
        page,
        "\n| scene | largest score of a pixel | largest score of a mean | mean z² | least p | |"
    )?;
    writeln!(page, "|---|---|---|---|---|---|")?;
    for scene in &scenes {
        let of_scene = || pairs.iter().filter(|pair| pair.scene == *scene);
        let most = |f: fn(&Pair) -> f64| of_scene().map(f).fold(0.0, f64::max);
        let spreads = || of_scene().map(|pair| pair.comparison.spread);
        writeln!(
            page,
            "| {scene} | {:.2} | {:.2} | {:.2} to {:.2} | {:.3} | {} |",
            most(|pair| pair.comparison.worst.z),
            most(|pair| pair.comparison.mean_z),
            spreads().fold(f64::INFINITY, f64::min),
            spreads().fold(0.0, f64::max),
            of_scene().map(|pair| pair.p).fold(1.0, f64::min),
            verdict(of_scene().all(Pair::agrees))
        )?;
    }

    writeln!(page, "\n### All pairs\n")?;
    writeln!(
        page,
        "| scene | first | second | largest score | at | first / second | score of the mean | mean z² | relMSE | p | |"
    )?;
    writeln!(page, "|---|---|---|---|---|---|---|---|---|---|---|")?;
    for pair in pairs {
        let Pair { scene, ways: [first, second], comparison: c, p } = pair;
        let [x, y] = c.worst.pixel;
        writeln!(
            page,
            "| {scene} | {first} | {second} | {:.2} | {x}, {y} {} | {:.5} | {:.2} | {:.3} | {:.1e} | {p:.3} | {} |",
            c.worst.z,
            c.worst.channel,
            c.mean_ratio,
            c.mean_z,
            c.spread,
            c.relative_mse,
            verdict(pair.agrees())
        )?;
    }
    Ok(())
}

fn others(page: &mut String, references: &[Checked]) -> std::fmt::Result {
    writeln!(page, "\n## Pictures by another renderer\n")?;
    writeln!(
        page,
        "Scenes by Benedikt Bitterli (CC0), references by his renderer Tungsten.\n\
         Means must be within 0.5 % for each channel, relMSE at most 0.002.\n"
    )?;
    writeln!(page, "| scene | samples per pixel | mean R | G | B | relMSE | |")?;
    writeln!(page, "|---|---|---|---|---|---|---|")?;
    for (Reference { name, spp, same, .. }, measured) in references {
        match measured {
            None => writeln!(page, "| {name} | | | | | | SKIPPED: no picture |")?,
            Some(m) => {
                let [r, g, b] =
                    m.mean_ratio.map(|ratio| format!("{:+.3} %", 100.0 * (ratio - 1.0)));
                let error = m.relative_mse;
                let verdict = if *same { verdict(m.agrees()) } else { "see below" };
                writeln!(page, "| {name} | {spp} | {r} | {g} | {b} | {error:.5} | {verdict} |")?;
            }
        }
    }
    writeln!(page)?;
    for (Reference { name, remark, .. }, _) in references {
        writeln!(page, "- {name}: {remark}")?;
    }
    Ok(())
}

fn verdict(agrees: bool) -> &'static str {
    if agrees { "agree" } else { "**DISAGREE**" }
}
