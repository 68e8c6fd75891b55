//! The page with the table.

use ppnpack_model::accuracy::Question;
use ppnpack_model::card::ModelCard;
use ppnpack_model::settings::LossOver;

use super::recipes::Recipe;
use super::results::{Results, Row};
use super::shares;
use crate::document;
use crate::statistics::Mean;
use crate::train::ranked;

pub(super) fn markdown(results: &Results) -> String {
    let mut text = "# Table 3: how often the optimum is among the best-scored K %\n\n".to_owned();
    let first = results.rows.first();
    if let Some(card) = first.and_then(|row| row.cards.first()) {
        text += &head(results, card);
    }
    for question in [
        Question::OverAll,
        Question::Proposed,
        Question::AmongFitting,
    ] {
        text += &table(results, question);
    }
    text += &choices(results);
    text + "\n![Accuracy over all placements against K](table3.svg)\n"
}

/// What all networks have in common.
fn head(results: &Results, card: &ModelCard) -> String {
    let training = &card.training;
    let sequences = training.sequences.map_or_else(
        || "the training split".to_owned(),
        |count| format!("{count} sequences of the training split"),
    );
    let over = match results.loss_over {
        LossOver::All => "all placements, as in the paper",
        LossOver::Fitting => "the placements that fit",
    };
    let validation = match (training.validation_tenths, &card.validation) {
        (tenths @ 1.., Some(validation)) => format!(
            "The validation split ({} candidates of {} sequences: {tenths} in ten, held out of the training split) chose the \
             epoch, and the settings where several were tried (below), by the accuracy at the smallest K{}. ",
            validation.candidates,
            validation.sequences,
            match Question::of_loss(results.loss_over) {
                Question::OverAll => " over all placements",
                _ => " of what the planner proposes",
            }
        ),
        _ => "There is no validation split: the weights are those of the last epoch. ".to_owned(),
    };
    let test = card.test.as_ref();
    let test = test.map(|test| {
        format!(
            "The test split ({} candidates of {} sequences, one in ten) was looked at once, at the end. The mean share of \
             all placements that fits is {:.1} % there.\n\n",
            test.candidates,
            test.sequences,
            100.0 * test.fitting_share
        )
    });
    let seeds = results.rows.first().map_or(1, |row| row.cards.len());
    let intervals = match seeds {
        0 | 1 => format!(
            "one network each, seed {}; intervals are 95 % over the test sequences, as candidates of a sequence are alike",
            training.seed
        ),
        _ => format!(
            "means over {seeds} networks each, from seed {} on; intervals are 95 % by Student's t over the networks, \
             which are tested on the same sequences",
            training.seed
        ),
    };
    format!(
        "Each network is trained alike: {sequences}, {} epochs of {} candidates, batches of {} steps, the loss over {over}. \
         {validation}{}Accuracies in %, {intervals}. In brackets the paper's Table III, whose network is wider and was \
         trained on its own data; its accuracy counts all placements, so it stands beside nothing else.\n\n",
        training.epochs,
        card.data.training_candidates,
        training.batch,
        test.unwrap_or_default(),
    )
}

fn table(results: &Results, question: Question) -> String {
    let (title, what) = match question {
        Question::OverAll => ("Over all placements: the paper's question", ""),
        Question::Proposed => (
            "What the planner proposes",
            ": it leaves out what does not fit, and K stays a share of all",
        ),
        Question::AmongFitting => ("Among those that fit", ""),
    };
    let mut text = format!(
        "## {title}\n\nThe optimum is {}{what}.\n\n| network |{} parameters | training |\n",
        ranked(question),
        shares::head()
    );
    text += "|---|---|---|---|---|---|---|---|\n";
    for row in &results.rows {
        let answer = row.answer(question);
        let paper = answer.and_then(|answer| answer.paper_percent);
        let paper: &[f64] = paper.as_ref().map_or(&[], |paper| paper);
        let accuracy = answer.map_or(&[][..], |answer| &answer.accuracy_percent);
        text += &format!("| {} |{}", row.network, shares::cells(accuracy, paper));
        let training = Mean::of(row.cards.iter().map(|card| card.training_s));
        let parameters = row.cards.first().map_or(0, |card| card.parameters);
        text += &format!(" {parameters} | {:.0} s |\n", training.mean);
    }
    text + "\n"
}

/// What validation chose among, where it chose.
fn choices(results: &Results) -> String {
    let question = Question::of_loss(results.loss_over);
    let rows: String = results
        .rows
        .iter()
        .map(|row| tried(row, question))
        .collect();
    if rows.is_empty() {
        return rows;
    }
    format!(
        "## What validation chose\n\nAccuracy on the validation split, {}, with the first seed. What was not chosen was \
         not tested.\n\n| network | settings |{} chosen |\n|---|---|---|---|---|---|---|---|\n{rows}",
        ranked(question),
        shares::head()
    )
}

fn tried(row: &Row, question: Question) -> String {
    let lines = row.tried.iter().map(|tried| {
        let accuracy = shares::percent(&[&tried.validation], question);
        let is_chosen = tried.recipe == row.recipe;
        format!(
            "| {} | {} |{} {} |\n",
            row.network,
            settings(&tried.recipe),
            shares::cells(&accuracy, &[]),
            if is_chosen { "yes" } else { "" }
        )
    });
    lines.collect()
}

/// A recipe in words.
fn settings(recipe: &Recipe) -> String {
    let cut_off = recipe.cut_off.map(|value| format!(", cut off at {value}"));
    format!(
        "rate {}, {}{}",
        recipe.learning_rate,
        document::name_of(&recipe.schedule),
        cut_off.unwrap_or_default()
    )
}
