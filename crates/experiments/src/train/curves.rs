//! The curves of a training.

use ppnpack_chart::{Curve, Lines};
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_files::write_whole;
use ppnpack_model::accuracy::{Question, SHARES_PERCENT};
use ppnpack_model::report::EpochReport;
use ppnpack_model::settings::TrainingRequest;

use crate::document;

/// Draws the curves of loss and accuracy, and keeps what they are drawn from.
pub(super) fn draw(request: &TrainingRequest, epochs: &[EpochReport]) -> Outcome {
    let losses = vec![
        curve("training".to_owned(), epochs, |report| {
            Some(report.training_loss)
        }),
        curve("validation".to_owned(), epochs, |report| {
            Some(report.validation.as_ref()?.loss)
        }),
    ];
    let question = Question::of_loss(request.settings.loss_over);
    let shares = SHARES_PERCENT.iter().enumerate();
    let accuracies = shares.map(|(at, percent)| {
        curve(format!("K = {percent} %"), epochs, |report| {
            let answers = report.validation.as_ref()?.accuracies.of(question);
            Some(100.0 * answers.get(at)?.share)
        })
    });
    let accuracies: Vec<Curve> = accuracies.collect();
    let optimum = "Optimum among the best-scored K %";
    for (name, title, y_label, curves) in [
        ("loss", "Loss", "Loss", losses),
        ("accuracy", optimum, "Validation candidates (%)", accuracies),
    ] {
        let curves: Vec<Curve> = curves
            .into_iter()
            .filter(|curve| !curve.points.is_empty())
            .collect();
        if curves.is_empty() {
            continue;
        }
        let chart = Lines {
            title: title.to_owned(),
            x_label: "Epoch".to_owned(),
            y_label: y_label.to_owned(),
            curves,
        };
        document::figure(&request.folder, name, chart.to_svg([800, 500]))?;
    }
    let history = serde_json::to_vec_pretty(epochs).or_run()?;
    Ok(write_whole(&request.folder.join("epochs.json"), &history)?)
}

/// A value by epoch, where there is one.
fn curve(
    name: String,
    epochs: &[EpochReport],
    value: impl Fn(&EpochReport) -> Option<f64>,
) -> Curve {
    let points = epochs
        .iter()
        .filter_map(|report| Some([report.epoch as f64, value(report)?]));
    Curve {
        name,
        points: points.collect(),
    }
}
