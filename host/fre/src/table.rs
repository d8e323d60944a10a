//! A table of typed columns, as sweeps and recordings come to: what a CSV says in words, for programs.

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Numbers; what is not known is NaN.
    Number,
    /// Numbers of single precision.
    Single,
    /// Whole numbers.
    Integer,
    /// True or false.
    Flag,
    /// Words.
    Word,
    /// Lists of numbers.
    List,
}

/// The values of a column, one per row.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// [`Kind::Number`].
    Number(Vec<f64>),
    /// [`Kind::Single`].
    Single(Vec<f32>),
    /// [`Kind::Integer`].
    Integer(Vec<Option<i64>>),
    /// [`Kind::Flag`].
    Flag(Vec<Option<bool>>),
    /// [`Kind::Word`].
    Word(Vec<Option<String>>),
    /// [`Kind::List`].
    List(Vec<Vec<f64>>),
}

/// A column: its name, which carries the unit, and its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its values.
    pub values: Values,
}

impl Values {
    /// No values yet.
    pub fn empty(kind: Kind) -> Self {
        match kind {
            Kind::Number => Self::Number(Vec::new()),
            Kind::Single => Self::Single(Vec::new()),
            Kind::Integer => Self::Integer(Vec::new()),
            Kind::Flag => Self::Flag(Vec::new()),
            Kind::Word => Self::Word(Vec::new()),
            Kind::List => Self::List(Vec::new()),
        }
    }

    /// What it holds.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Number(_) => Kind::Number,
            Self::Single(_) => Kind::Single,
            Self::Integer(_) => Kind::Integer,
            Self::Flag(_) => Kind::Flag,
            Self::Word(_) => Kind::Word,
            Self::List(_) => Kind::List,
        }
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::Number(values) => values.len(),
            Self::Single(values) => values.len(),
            Self::Integer(values) => values.len(),
            Self::Flag(values) => values.len(),
            Self::Word(values) => values.len(),
            Self::List(values) => values.len(),
        }
    }

    /// True without values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Takes a CSV's cell; false if it does not hold such a value.
    fn take(&mut self, cell: &str) -> bool {
        let known = !cell.is_empty();
        match self {
            Self::Number(values) => match cell.parse() {
                Ok(value) => values.push(value),
                Err(_) if !known => values.push(f64::NAN),
                Err(_) => return false,
            },
            Self::Single(values) => match cell.parse() {
                Ok(value) => values.push(value),
                Err(_) if !known => values.push(f32::NAN),
                Err(_) => return false,
            },
            Self::Integer(values) => match cell.parse() {
                Ok(value) => values.push(Some(value)),
                Err(_) if !known => values.push(None),
                Err(_) => return false,
            },
            Self::Flag(values) => match cell.parse() {
                Ok(value) => values.push(Some(value)),
                Err(_) if !known => values.push(None),
                Err(_) => return false,
            },
            Self::Word(values) => values.push(known.then(|| cell.to_owned())),
            Self::List(values) => {
                let Ok(list) = cell.split_whitespace().map(str::parse).collect() else { return false };
                values.push(list);
            }
        }
        true
    }
}

/// A CSV's rows as columns. The CSV has no quoted cells: none of ours has.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The columns, all of one length.
    pub columns: Vec<Column>,
}

impl Table {
    /// Without rows; `kind` says what a column of this name holds.
    pub fn new<'n>(names: impl IntoIterator<Item = &'n str>, kind: impl Fn(&str) -> Kind) -> Self {
        let column = |name: &str| Column { name: name.to_owned(), values: Values::empty(kind(name)) };
        Self { columns: names.into_iter().map(column).collect() }
    }

    /// Takes a line of the CSV; false, the table being of no use then, if it has other cells.
    #[must_use]
    pub fn take(&mut self, line: &str) -> bool {
        let mut cells = line.split(',');
        let fits = self.columns.iter_mut().all(|column| cells.next().is_some_and(|cell| column.values.take(cell)));
        fits && cells.next().is_none()
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// Forgets the rows.
    pub fn clear(&mut self) {
        for column in &mut self.columns {
            column.values = Values::empty(column.values.kind());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Kind, Table, Values};

    #[test]
    fn cells_become_values_and_what_is_not_known_stays_unknown() {
        let kind = |name: &str| match name {
            "n" => Kind::Integer,
            "s" => Kind::Word,
            "b" => Kind::Flag,
            "l" => Kind::List,
            _ => Kind::Number,
        };
        let mut table = Table::new(["n", "x", "s", "b", "l"], kind);
        assert!(table.take("1,0.1,folded,true,1 2.5"));
        assert!(table.take(",,,,"));
        assert_eq!(table.rows(), 2);
        assert_eq!(table.columns[0].values, Values::Integer(vec![Some(1), None]));
        assert!(matches!(&table.columns[1].values, Values::Number(x) if x[0] == 0.1 && x[1].is_nan()));
        assert_eq!(table.columns[2].values, Values::Word(vec![Some("folded".into()), None]));
        assert_eq!(table.columns[3].values, Values::Flag(vec![Some(true), None]));
        assert_eq!(table.columns[4].values, Values::List(vec![vec![1.0, 2.5], vec![]]));
        for line in ["1,0.1,a,true", "1,0.1,a,true,1,2", "1.5,0.1,a,true,1", "1,x,a,true,1"] {
            assert!(!table.clone().take(line), "{line}");
        }
        table.clear();
        assert_eq!(table.rows(), 0);
    }
}
