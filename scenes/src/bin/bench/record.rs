//! One file with the figures of all benchmarks, in long form: what they are of (machine, commit, peers, date) and a line
//! for each number.

use std::path::PathBuf;
use std::process::Command as Process;

use bdtree_measure::table::Cell;
use bdtree_scenes::report::{commit, write};

use crate::prelude::*;
use crate::{Cli, measure};

#[derive(Args)]
pub(crate) struct Arguments {
    /// Where the record goes; docs/measured pages quote it
    #[arg(long, default_value = "docs/measured/record.csv")]
    out: PathBuf,
    /// Only these benchmarks
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
}

/// What is run, as it would be typed.
const BENCHMARKS: [&[&str]; 7] = [
    &["ball"],
    &["kernel"],
    &["depth", "--rings", "94", "--frames", "12", "--rounds", "3"],
    &["coherence"],
    &["broad", "--rings", "67"],
    &["hard-cases"],
    &["workloads"],
];

/// Libraries whose versions belong to the figures.
const LIBRARIES: [&str; 4] = ["embree", "obvhs", "parry3d", "tinybvh-rs"];

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let mut record = Table::new(
        "record",
        "All figures",
        &["benchmark", "table", "row", "column", "value"],
    );
    let mut about = |what: &str, value: String| {
        let words = ["record", "about", what, "", &value];
        record.rows.push(words.map(Cell::from).to_vec());
    };
    about("machine", machine::processor());
    about("commit", commit());
    about("date", today()?);
    for (name, version) in versions() {
        about(name, version);
    }
    let is_asked =
        |name: &str| arguments.only.is_empty() || arguments.only.iter().any(|n| n == name);
    for words in BENCHMARKS.iter().filter(|words| is_asked(words[0])) {
        eprintln!("bench {}", words.join(" "));
        let cli = Cli::try_parse_from([&["bench"], *words].concat())?;
        let (name, tables) = measure(&cli)?;
        for table in tables {
            append(&mut record, name, &table);
        }
    }
    write(&arguments.out, &record.csv())?;
    println!("{}: {} figures", arguments.out.display(), record.rows.len());
    Ok(())
}

/// A line for each number of a table; a row is named by its texts.
fn append(record: &mut Table, benchmark: &str, table: &Table) {
    for (number, row) in table.rows.iter().enumerate() {
        let texts = row.iter().filter_map(|cell| match cell {
            Cell::Text(text) => Some(text.as_str()),
            _ => None,
        });
        let texts = texts.collect::<Vec<_>>().join(", ");
        let name = if texts.is_empty() {
            format!("row {number}")
        } else {
            texts
        };
        for (column, cell) in table.columns.iter().zip(row) {
            if let Cell::Count(_) | Cell::Number(_) = cell {
                record.rows.push(vec![
                    benchmark.into(),
                    table.key.into(),
                    name.as_str().into(),
                    column.as_str().into(),
                    cell.clone(),
                ]);
            }
        }
    }
}

/// The versions of the lock file, of the libraries that this program was built with.
fn versions() -> impl Iterator<Item = (&'static str, String)> {
    let lock = include_str!("../../../../Cargo.lock");
    let version = move |name: &str| {
        let (_, rest) = lock.split_once(&format!("name = \"{name}\"\nversion = \""))?;
        Some(rest.split('"').next()?.to_string())
    };
    let has_peers = cfg!(feature = "peers");
    let libraries = LIBRARIES.into_iter().filter(move |_| has_peers);
    libraries.filter_map(move |name| Some((name, version(name)?)))
}

fn today() -> Result<String> {
    let output = Process::new("date").arg("+%Y-%m-%d").output()?;
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_has_a_line() {
        let rows = [
            row! {"who" => "a, b", "n" => 2_usize, "s" => 0.5},
            row! {"who" => "c", "n" => 3_usize},
        ];
        let mut record = Table::new(
            "record",
            "",
            &["benchmark", "table", "row", "column", "value"],
        );
        append(&mut record, "ball", &table("times", "Times", &rows));
        append(
            &mut record,
            "ball",
            &table("bare", "Bare", &[row! {"n" => 1_usize}]),
        );
        assert_eq!(
            record.csv(),
            "benchmark,table,row,column,value\nball,times,\"a, b\",n,2\nball,times,\"a, b\",s,0.5\n\
             ball,times,c,n,3\nball,bare,row 0,n,1\n"
        );
    }

    #[test]
    fn benchmarks_are_commands() {
        for words in BENCHMARKS {
            Cli::try_parse_from([&["bench"], words].concat()).expect("a command");
        }
    }
}
