//! Tables of numbers as CSV files, compressed where their names end in `.gz`: lines `# key: value` say what they are of, then
//! come the columns' names and a line per row.

use std::error::Error;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::Path;

use bdtree_output::write_whole;
use flate2::Compression;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;

/// What such a file holds.
#[derive(Debug, Clone, Default)]
pub(crate) struct LogFile {
    /// Keys and values of what it is of; a key may come again.
    pub(crate) about: Vec<(String, String)>,
    pub(crate) columns: Vec<String>,
    /// A number for each column; an empty cell is not a number.
    pub(crate) rows: Vec<Vec<f64>>,
}

impl LogFile {
    /// # Errors
    /// A file that cannot be read or is not such a table, with the first line that is wrong.
    pub(crate) fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let file = File::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let file = BufReader::new(file);
        let found = match is_compressed(path) {
            true => Self::parse(BufReader::new(MultiGzDecoder::new(file))),
            false => Self::parse(file),
        };
        let wrong = |(line, what)| format!("{}, line {line}: {what}", path.display());
        Ok(found.map_err(wrong)?)
    }

    /// Fails with the number of a line and what is wrong there.
    fn parse(text: impl BufRead) -> Result<Self, (usize, String)> {
        let mut all = Self::default();
        let mut end = 1;
        for (number, line) in (1..).zip(text.lines()) {
            let wrong = |what: &str| (number, what.to_string());
            // Not the end of a compressed file that is cut off, nor one that is damaged.
            let line = line.map_err(|error| wrong(&format!("cannot be read: {error}")))?;
            if let Some(about) = line.strip_prefix("# ").filter(|_| all.columns.is_empty()) {
                let about = about.split_once(": ");
                let (key, value) = about.ok_or_else(|| wrong("is not `# key: value`"))?;
                all.about.push((key.to_string(), value.to_string()));
            } else if all.columns.is_empty() {
                all.columns = line.split(',').map(str::to_string).collect();
                if all.columns.iter().any(String::is_empty) {
                    return Err(wrong("names of columns are missing"));
                }
            } else {
                let numbers: Option<Vec<f64>> = line.split(',').map(number_of).collect();
                let row = numbers.filter(|row| row.len() == all.columns.len());
                let expected = || wrong(&format!("is no row of {} numbers", all.columns.len()));
                all.rows.push(row.ok_or_else(expected)?);
            }
            end = number + 1;
        }
        if all.columns.is_empty() {
            return Err((end, "names of columns are missing".to_string()));
        }
        Ok(all)
    }

    /// Writes it, whole or not at all.
    pub(crate) fn write(&self, path: &Path) -> Result<(), Box<dyn Error>> {
        write_whole(path, |out| {
            if !is_compressed(path) {
                return self.lines(out);
            }
            let mut packed = GzEncoder::new(out, Compression::best());
            self.lines(&mut packed)?;
            packed.finish().map(drop)
        })?;
        Ok(())
    }

    fn lines(&self, out: &mut dyn Write) -> io::Result<()> {
        for (key, value) in &self.about {
            writeln!(out, "# {key}: {value}")?;
        }
        writeln!(out, "{}", self.columns.join(","))?;
        let text = |x: &f64| match x.is_nan() {
            true => String::new(),
            false => x.to_string(),
        };
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(text).collect();
            writeln!(out, "{}", cells.join(","))?;
        }
        Ok(())
    }

    /// Says something that it is of, on one line.
    pub(crate) fn say(&mut self, key: &str, value: impl ToString) {
        let value = value.to_string().replace(['\n', '\r'], " ");
        self.about.push((key.to_string(), value));
    }

    /// All that it says under a key.
    pub(crate) fn said<'f>(&'f self, key: &'f str) -> impl Iterator<Item = &'f str> + 'f {
        let of_key = self.about.iter().filter(move |(own, _)| own == key);
        of_key.map(|(_, value)| value.as_str())
    }

    /// The numbers of a column, if there is one of that name.
    pub(crate) fn column(&self, name: &str) -> Option<Vec<f64>> {
        let at = self.columns.iter().position(|own| own == name)?;
        Some(self.rows.iter().map(|row| row[at]).collect())
    }

    /// Leaves six digits of numbers that are not whole, which makes compressed files half as large.
    pub(crate) fn round(&mut self) {
        for x in self.rows.iter_mut().flatten() {
            if x.is_finite() && x.fract() != 0.0 {
                *x = format!("{x:.5e}").parse().unwrap_or(*x);
            }
        }
    }
}

fn is_compressed(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "gz")
}

fn number_of(cell: &str) -> Option<f64> {
    match cell {
        "" => Some(f64::NAN),
        cell => cell.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn some() -> LogFile {
        let mut log = LogFile {
            columns: vec!["step".to_string(), "seconds".to_string()],
            ..LogFile::default()
        };
        log.say("program", "chairs");
        log.say("part", "from step 1: here");
        log.say("part", "from step 2:\nthere: so");
        let numbers = (1..2000).map(|step| vec![f64::from(step), (0.37 * f64::from(step)).sin()]);
        log.rows = numbers.collect();
        log.rows[7][1] = f64::NAN;
        log.rows[8] = vec![1_234_567_890.0, 1.0 / 3.0];
        log
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["log.csv", "log.csv.gz"] {
            let path = folder.path().join(name);
            let log = some();
            log.write(&path).expect("written");
            let again = LogFile::read(&path).expect("read");
            assert_eq!(again.columns, log.columns);
            assert_eq!(again.about, log.about);
            let parts: Vec<&str> = again.said("part").collect();
            assert_eq!(parts, ["from step 1: here", "from step 2: there: so"]);
            let bits = |log: &LogFile| -> Vec<u64> {
                log.rows.iter().flatten().map(|x| x.to_bits()).collect()
            };
            assert!(bits(&again) == bits(&log));
            let packed = fs::read(&path).expect("bytes");
            assert_eq!(packed.starts_with(&[0x1f, 0x8b]), name.ends_with("gz"));
            // The same bytes every time.
            again.write(&path).expect("written");
            assert!(fs::read(&path).expect("bytes") == packed);
        }
    }

    #[test]
    fn rounding_leaves_whole_numbers() {
        let mut log = some();
        log.round();
        assert_eq!(log.rows[8], [1_234_567_890.0, 0.333333]);
        assert!(log.rows[7][1].is_nan());
        let column = log.column("step").expect("a column");
        assert_eq!((column[3], log.column("more")), (4.0, None));
    }

    /// File and line are named, whatever is wrong.
    #[test]
    fn damaged_logs_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let refused = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            fs::write(&path, bytes).expect("written");
            let error = LogFile::read(&path).expect_err(name).to_string();
            let error = error.strip_prefix(&*path.display().to_string());
            error.expect("the file").to_string()
        };
        for (text, says) in [
            ("", ", line 1: names of columns are missing"),
            ("# a: b\n", ", line 2: names of columns are missing"),
            ("# a: b\na,,b\n", ", line 2: names of columns are missing"),
            ("# a\na,b\n", ", line 1: is not `# key: value`"),
            ("a,b\n1,2\n1,2,3\n", ", line 3: is no row of 2 numbers"),
            ("a,b\n1,2\n1,x\n", ", line 3: is no row of 2 numbers"),
            ("a,b\n1,2\n# c: d\n", ", line 3: is no row of 2 numbers"),
        ] {
            assert_eq!(refused("log.csv", text.as_bytes()), says);
        }
        let path = folder.path().join("whole.csv.gz");
        some().write(&path).expect("written");
        let whole = fs::read(&path).expect("bytes");
        for len in [5, whole.len() / 2, whole.len() - 1] {
            let error = refused("cut.csv.gz", &whole[..len]);
            assert!(error.starts_with(", line "), "{len}: {error}");
            assert!(error.contains("cannot be read"), "{len}: {error}");
        }
        let mut changed = whole.clone();
        let crc = whole.len() - 8;
        changed[crc] ^= 1;
        let error = refused("changed.csv.gz", &changed);
        // Behind three lines that say what it is, the columns and 1999 rows.
        assert!(error.starts_with(", line 2004: cannot be read"), "{error}");
        let error = LogFile::read(&folder.path().join("none.csv")).expect_err("no file");
        assert!(error.to_string().contains("none.csv: "), "{error}");
    }
}
