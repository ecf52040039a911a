//! Tables of numbers with named columns.

/// A CSV file with one line of names.
#[derive(Debug)]
pub struct Table {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    pub fn parse(text: &str) -> Self {
        let mut lines = text.lines();
        let names = lines.next().unwrap().split(',').map(String::from).collect();
        let rows =
            lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
        Self { names, rows }
    }

    pub fn len(&self) -> usize {
        self.rows.len()
    }

    pub fn get(&self, row: usize, name: &str) -> Option<f64> {
        let column = self.names.iter().position(|known| known == name)?;
        Some(self.rows[row][column])
    }

    /// The cells under `name0`, `name1`, ...; none if there is no such column.
    pub fn vector(&self, row: usize, name: &str) -> Vec<f64> {
        let columns = self.names.iter().enumerate().filter(|(_, known)| {
            known.strip_prefix(name).is_some_and(|rest| {
                !rest.is_empty() && rest.bytes().all(|byte| byte.is_ascii_digit())
            })
        });
        columns.map(|(column, _)| self.rows[row][column]).collect()
    }
}
