//! Tables of numbers.

/// A CSV file with one line of names.
pub struct Table {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    pub fn parse(text: &str) -> Self {
        let mut lines = text.lines();
        let names = lines.next().unwrap().split(',').map(String::from).collect();
        Self { names, rows: lines.map(numbers).collect() }
    }

    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// The cells of a row under `name0`, `name1`, ...
    pub fn vector(&self, row: usize, name: &str) -> Vec<f64> {
        (0..).map_while(|i| self.cell(row, &format!("{name}{i}"))).collect()
    }

    pub fn get(&self, row: usize, name: &str) -> f64 {
        self.cell(row, name).unwrap()
    }

    fn cell(&self, row: usize, name: &str) -> Option<f64> {
        let column = self.names.iter().position(|known| known == name)?;
        Some(self.rows[row][column])
    }
}

/// The numbers of the line that starts with this name.
pub fn row(text: &str, name: &str) -> Vec<f64> {
    let mut lines = text.lines().filter_map(|line| line.split_once(','));
    numbers(lines.find(|(known, _)| *known == name).unwrap().1)
}

fn numbers(line: &str) -> Vec<f64> {
    line.split(',').map(|cell| cell.parse().unwrap()).collect()
}
