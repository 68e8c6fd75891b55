//! Results of experiments as JSON, of which programs in `experiments` make pages.

use std::path::{Path, PathBuf};

use clap::Args;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::output::{print_json, print_line};
use ppnpack_files::write_whole;
use serde_json::{Value, json};

use crate::origin::Origin;

/// Options of the results' files.
#[derive(Debug, Args)]
pub(crate) struct OutOptions {
    /// Folder of the results as JSON [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print the results as JSON instead of what makes a page of them
    #[arg(long)]
    json: bool,
}

impl OutOptions {
    pub(crate) fn folder(&self, name: &str) -> PathBuf {
        self.out
            .clone()
            .unwrap_or_else(|| Path::new("out").join(name))
    }

    /// Writes `<name>.json`, with what made it, and prints it, or how `experiments` makes its page.
    pub(crate) fn publish(&self, name: &str, results: Value, program: &str, more: &str) -> Outcome {
        let results = with(results, json!({ "origin": Origin::now()? }));
        let path = self.folder(name).join(format!("{name}.json"));
        write_whole(&path, &serde_json::to_vec_pretty(&results).or_run()?)?;
        if self.json {
            return Ok(print_json(&results)?);
        }
        let path = path.display();
        Ok(print_line(&format!(
            "For its page: python experiments/{program}.py {path}{more}"
        ))?)
    }
}

pub(crate) fn with(results: Value, others: Value) -> Value {
    match (results, others) {
        (Value::Object(mut results), Value::Object(others)) => {
            results.extend(others);
            Value::Object(results)
        }
        (results, _) => results,
    }
}
