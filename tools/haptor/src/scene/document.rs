//! A TOML document whose every value knows its line, so that a message can name file, line, key and value.
//!
//! A [`Section`] is read key by key; each reader states what is allowed. Keys that nobody asked for are errors when the section
//! is [finished](Section::finish): a misspelt key is never ignored.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What a key is called, what it may hold and how it looks.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its name within its section.
    pub name: &'static str,
    /// The allowed values in words.
    pub allowed: &'static str,
    /// A value that is good.
    pub example: &'static str,
}

/// Short form of [`Key`].
pub const fn key(name: &'static str, allowed: &'static str, example: &'static str) -> Key {
    Key { name, allowed, example }
}

/// A scene file is wrong: where and how.
#[derive(Debug, thiserror::Error)]
#[error("{file}:{line}: {what}")]
pub struct SceneError {
    /// The file as the user named it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Key, value, what is allowed and what to do.
    pub what: String,
}

/// Where a value stands and how it was written.
#[derive(Clone, Debug)]
struct Place {
    line: usize,
    written: String,
}

/// The text of a scene file and the places of what has been read from it.
#[derive(Debug)]
pub struct Document<'a> {
    file: &'a str,
    text: &'a str,
    places: RefCell<BTreeMap<String, Place>>,
}

impl<'a> Document<'a> {
    /// A document called `file` in messages.
    pub fn new(file: &'a str, text: &'a str) -> Self {
        Self { file, text, places: RefCell::default() }
    }

    /// Parses the text.
    ///
    /// # Errors
    /// [`SceneError`] at the first place that is no TOML.
    pub fn parse(&self) -> Result<DeTable<'a>, SceneError> {
        match DeTable::parse(self.text) {
            Ok(table) => Ok(table.into_inner()),
            Err(error) => {
                let at = error.span().map_or(self.text.len(), |span| span.start);
                Err(self.error(self.line_at(at), format!("not TOML: {}", one_line(error.message()))))
            }
        }
    }

    /// The whole file as a section without a name.
    pub fn root<'d>(&'d self, table: &'d DeTable<'a>) -> Section<'d, 'a> {
        let line = self.text.lines().count().max(1);
        Section { document: self, name: String::new(), table, line, asked: RefCell::default() }
    }

    /// The error for a value that the core refuses: `name` is the full key, with or without an index or a remark behind it.
    pub fn refused(&self, name: &str, value: impl std::fmt::Display, allowed: &str) -> SceneError {
        let full = name.split([' ', '[']).next().unwrap_or(name);
        let name = if self.places.borrow().contains_key(name) { name } else { full };
        match self.places.borrow().get(name) {
            Some(Place { line, written }) => {
                self.error(*line, format!("{name} = {written}: allowed is {allowed}; correct the value"))
            }
            None => self.error(1, format!("{name} = {value}: allowed is {allowed}; correct the value")),
        }
    }

    fn error(&self, line: usize, what: String) -> SceneError {
        SceneError { file: self.file.to_owned(), line, what }
    }

    fn line_at(&self, offset: usize) -> usize {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        1 + before.iter().filter(|&&byte| byte == b'\n').count()
    }

    fn place(&self, span: Range<usize>) -> Place {
        let written = self.text.get(span.clone()).unwrap_or_default();
        Place { line: self.line_at(span.start), written: one_line(written) }
    }
}

/// Longest value shown in a message \[characters\]: the line stays readable.
const SHOWN: usize = 60;

/// The text on one line, shortened.
fn one_line(text: &str) -> String {
    let joined = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if joined.chars().count() <= SHOWN {
        return joined;
    }
    joined.chars().take(SHOWN).chain("...".chars()).collect()
}

/// One table of the file.
#[derive(Debug)]
pub struct Section<'d, 'a> {
    document: &'d Document<'a>,
    name: String,
    table: &'d DeTable<'a>,
    line: usize,
    asked: RefCell<Vec<&'static str>>,
}

type Value<'d, 'a> = &'d Spanned<DeValue<'a>>;

impl<'d, 'a> Section<'d, 'a> {
    /// A number; integers count.
    pub fn number(&self, key: Key) -> Result<f32, SceneError> {
        self.number_in(key, self.required(key)?)
    }

    /// A number or nothing.
    pub fn optional_number(&self, key: Key) -> Result<Option<f32>, SceneError> {
        self.find(key.name).map(|value| self.number_in(key, value)).transpose()
    }

    /// A whole number from 0 up, or nothing.
    pub fn optional_count(&self, key: Key) -> Result<Option<usize>, SceneError> {
        let Some(value) = self.find(key.name) else { return Ok(None) };
        let DeValue::Integer(integer) = value.get_ref() else { return Err(self.wrong_type(key, value)) };
        let count = usize::from_str_radix(integer.as_str(), integer.radix());
        count.map(Some).map_err(|_| self.out_of_range(key, value))
    }

    /// True, false or nothing.
    pub fn optional_flag(&self, key: Key) -> Result<Option<bool>, SceneError> {
        let Some(value) = self.find(key.name) else { return Ok(None) };
        value.get_ref().as_bool().map(Some).ok_or_else(|| self.wrong_type(key, value))
    }

    /// A list of exactly `N` numbers.
    pub fn numbers<const N: usize>(&self, key: Key) -> Result<[f32; N], SceneError> {
        self.numbers_in(key, self.required(key)?)
    }

    /// A list of exactly `N` numbers, or nothing.
    pub fn optional_numbers<const N: usize>(&self, key: Key) -> Result<Option<[f32; N]>, SceneError> {
        self.find(key.name).map(|value| self.numbers_in(key, value)).transpose()
    }

    /// A text.
    pub fn text(&self, key: Key) -> Result<&'d str, SceneError> {
        let value = self.required(key)?;
        value.get_ref().as_str().ok_or_else(|| self.wrong_type(key, value))
    }

    /// A text, or nothing.
    pub fn optional_text(&self, key: Key) -> Result<Option<&'d str>, SceneError> {
        let Some(value) = self.find(key.name) else { return Ok(None) };
        value.get_ref().as_str().map(Some).ok_or_else(|| self.wrong_type(key, value))
    }

    /// The path of a file that the scene names, relative to the scene's own folder.
    pub fn beside(&self, name: &str) -> PathBuf {
        Path::new(self.document.file).parent().unwrap_or(Path::new("")).join(name)
    }

    /// One of the listed words.
    pub fn word<T: Copy>(&self, key: Key, words: &[(&str, T)]) -> Result<T, SceneError> {
        self.word_in(key, self.required(key)?, words)
    }

    /// One of the listed words, or nothing.
    pub fn optional_word<T: Copy>(&self, key: Key, words: &[(&str, T)]) -> Result<Option<T>, SceneError> {
        self.find(key.name).map(|value| self.word_in(key, value, words)).transpose()
    }

    /// A section within, or nothing.
    pub fn optional_section(&self, key: Key) -> Result<Option<Section<'d, 'a>>, SceneError> {
        let Some(value) = self.find(key.name) else { return Ok(None) };
        let table = value.get_ref().as_table().ok_or_else(|| self.wrong_type(key, value))?;
        Ok(Some(self.within(self.full(key.name), value, table)))
    }

    /// A section that must be there.
    pub fn section(&self, key: Key) -> Result<Section<'d, 'a>, SceneError> {
        self.required(key)?;
        self.optional_section(key)?.ok_or_else(|| self.missing(key))
    }

    /// A list of sections, each called `key[i]`.
    pub fn sections(&self, key: Key) -> Result<Vec<Section<'d, 'a>>, SceneError> {
        let value = self.required(key)?;
        let list = value.get_ref().as_array().ok_or_else(|| self.wrong_type(key, value))?;
        let name = |index| format!("{}[{index}]", self.full(key.name));
        let section = |(index, item): (usize, Value<'d, 'a>)| {
            let table = item.get_ref().as_table().ok_or_else(|| self.wrong_type(key, item))?;
            Ok(self.within(name(index), item, table))
        };
        list.iter().enumerate().map(section).collect()
    }

    /// Every key has been read; what is left over is an error that lists what `whose` takes.
    pub fn finish(&self, whose: &str) -> Result<(), SceneError> {
        let asked = self.asked.borrow();
        match self.table.keys().find(|key| !asked.contains(&key.get_ref().as_ref())) {
            Some(stranger) => Err(self.unknown(stranger, whose, &asked)),
            None => Ok(()),
        }
    }

    /// An error about a key of this section.
    pub fn error(&self, name: &str, what: &str) -> SceneError {
        let full = self.full(name);
        match self.document.places.borrow().get(&full) {
            Some(Place { line, written }) => self.document.error(*line, format!("{full} = {written}: {what}")),
            None => self.document.error(self.line, format!("{full}: {what}")),
        }
    }

    /// Tells on standard error what is allowed but worth knowing about a key of this section.
    pub fn note(&self, name: &str, what: &str) {
        eprintln!("haptor: note: {}", self.error(name, what));
    }

    fn within(&self, name: String, value: Value<'d, 'a>, table: &'d DeTable<'a>) -> Section<'d, 'a> {
        let line = self.document.line_at(value.span().start);
        Section { document: self.document, name, table, line, asked: RefCell::default() }
    }

    fn full(&self, name: &str) -> String {
        if self.name.is_empty() { name.to_owned() } else { format!("{}.{name}", self.name) }
    }

    /// Looks a key up, notes that it was asked for and where it stands.
    fn find(&self, name: &'static str) -> Option<Value<'d, 'a>> {
        self.asked.borrow_mut().push(name);
        let (_, value) = self.table.iter().find(|(key, _)| key.get_ref() == name)?;
        let place = self.document.place(value.span());
        self.document.places.borrow_mut().insert(self.full(name), place);
        Some(value)
    }

    fn required(&self, key: Key) -> Result<Value<'d, 'a>, SceneError> {
        self.find(key.name).ok_or_else(|| self.missing(key))
    }

    fn number_in(&self, key: Key, value: Value<'d, 'a>) -> Result<f32, SceneError> {
        let number = number(value.get_ref()).ok_or_else(|| self.wrong_type(key, value))?;
        let narrow = number as f32;
        if narrow.is_nan() || narrow.is_infinite() && number.is_finite() {
            return Err(self.out_of_range(key, value));
        }
        Ok(narrow)
    }

    fn numbers_in<const N: usize>(&self, key: Key, value: Value<'d, 'a>) -> Result<[f32; N], SceneError> {
        let list = value.get_ref().as_array().ok_or_else(|| self.wrong_type(key, value))?;
        let numbers: Vec<f32> = list.iter().map(|item| self.number_in(key, item)).collect::<Result<_, _>>()?;
        numbers.try_into().map_err(|_| self.out_of_range(key, value))
    }

    fn word_in<T: Copy>(&self, key: Key, value: Value<'d, 'a>, words: &[(&str, T)]) -> Result<T, SceneError> {
        let text = value.get_ref().as_str().ok_or_else(|| self.wrong_type(key, value))?;
        match words.iter().find(|(word, _)| *word == text) {
            Some(&(_, meaning)) => Ok(meaning),
            None => Err(self.error(key.name, &format!("allowed is {}{}", key.allowed, meant(text, words.iter().map(|w| w.0))))),
        }
    }

    fn missing(&self, key: Key) -> SceneError {
        let full = self.full(key.name);
        let similar = self.table.keys().find(|other| is_similar(other.get_ref(), key.name));
        match similar {
            Some(other) => self.unknown(other, &self.owner(), &[key.name]),
            None => {
                self.document.error(self.line, format!("{full} is missing: add {} = {} ({})", key.name, key.example, key.allowed))
            }
        }
    }

    fn owner(&self) -> String {
        if self.name.is_empty() { "the scene".to_owned() } else { format!("[{}]", self.name) }
    }

    fn unknown(&self, stranger: &Spanned<std::borrow::Cow<'_, str>>, whose: &str, known: &[&str]) -> SceneError {
        let name = stranger.get_ref();
        let value = self.table.get(name.as_ref()).map(|value| self.document.place(value.span()).written);
        let value = value.filter(|text| !text.starts_with('[')).map_or(String::new(), |text| format!(" = {text}"));
        let meant = meant(name, known.iter().copied());
        let what = format!(
            "{}{value}: unknown key; {whose} takes {}{meant}; remove or rename the key",
            self.full(name),
            known.join(", ")
        );
        self.document.error(self.document.line_at(stranger.span().start), what)
    }

    fn wrong_type(&self, key: Key, value: Value<'d, 'a>) -> SceneError {
        let Place { line, written } = self.document.place(value.span());
        let found = value.get_ref().type_str();
        let what = format!(
            "{} = {written}: is of type {found}, allowed is {}; write e.g. {} = {}",
            self.full(key.name),
            key.allowed,
            key.name,
            key.example
        );
        self.document.error(line, what)
    }

    fn out_of_range(&self, key: Key, value: Value<'d, 'a>) -> SceneError {
        let Place { line, written } = self.document.place(value.span());
        let what = format!("{} = {written}: allowed is {}; correct the value", self.full(key.name), key.allowed);
        self.document.error(line, what)
    }
}

/// The number that a value is, if it is one.
fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|whole| whole as f64),
        _ => None,
    }
}

fn is_similar(written: &str, name: &str) -> bool {
    // two strokes apart, and not nearly a different word altogether
    written != name && name.len() > 2 && strsim::damerau_levenshtein(written, name) <= 2
}

fn meant<'w>(written: &str, mut names: impl Iterator<Item = &'w str>) -> String {
    names.find(|name| is_similar(written, name)).map_or(String::new(), |name| format!(" (did you mean {name}?)"))
}
