//! Prints a message's type in the notation of [`crate::schema`], by serializing a value of it.

use std::format;
use std::string::{String, ToString};

use serde::ser::{self, Impossible, Serialize, Serializer};

/// `Name{field:type,...}` of a structure.
pub fn type_text<T: Serialize>(value: &T) -> String {
    value.serialize(Text { inner: false }).unwrap()
}

/// One case of an enum, with what it carries.
pub fn case_text<T: Serialize>(value: &T) -> String {
    type_text(value)
}

#[derive(Clone, Copy)]
struct Text {
    /// Inside another type a structure or an enum is told by its name alone.
    inner: bool,
}

const INNER: Text = Text { inner: true };

#[derive(Debug)]
pub struct NotInTheNotation;

impl std::fmt::Display for NotInTheNotation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a type that the tables do not use")
    }
}

impl std::error::Error for NotInTheNotation {}

impl ser::Error for NotInTheNotation {
    fn custom<T: std::fmt::Display>(_: T) -> Self {
        Self
    }
}

type Out = Result<String, NotInTheNotation>;
type Never = Impossible<String, NotInTheNotation>;

/// Fields of a structure, or elements of an array.
struct Parts {
    name: &'static str,
    inner: bool,
    text: String,
    count: usize,
}

impl Parts {
    fn new(name: &'static str, inner: bool) -> Self {
        Self { name, inner, text: String::new(), count: 0 }
    }

    fn field<T: Serialize + ?Sized>(&mut self, name: &str, value: &T) -> Result<(), NotInTheNotation> {
        if self.count > 0 {
            self.text.push(',');
        }
        self.text += &format!("{name}:{}", value.serialize(INNER)?);
        self.count += 1;
        Ok(())
    }

    fn finish(self) -> Out {
        Ok(if self.inner { self.name.to_string() } else { format!("{}{{{}}}", self.name, self.text) })
    }
}

impl ser::SerializeStruct for Parts {
    type Ok = String;
    type Error = NotInTheNotation;
    fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Result<(), NotInTheNotation> {
        self.field(key, value)
    }
    fn end(self) -> Out {
        self.finish()
    }
}

impl ser::SerializeStructVariant for Parts {
    type Ok = String;
    type Error = NotInTheNotation;
    fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Result<(), NotInTheNotation> {
        self.field(key, value)
    }
    fn end(self) -> Out {
        self.finish()
    }
}

impl ser::SerializeTuple for Parts {
    type Ok = String;
    type Error = NotInTheNotation;
    fn serialize_element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), NotInTheNotation> {
        self.text = value.serialize(INNER)?;
        self.count += 1;
        Ok(())
    }
    fn end(self) -> Out {
        Ok(format!("[{};{}]", self.text, self.count))
    }
}

impl ser::SerializeSeq for Parts {
    type Ok = String;
    type Error = NotInTheNotation;
    fn serialize_element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), NotInTheNotation> {
        ser::SerializeTuple::serialize_element(self, value)
    }
    fn end(self) -> Out {
        Ok(format!("[{}]", self.text))
    }
}

macro_rules! scalars {
    ($($method:ident $type:ty),*) => {
        $(fn $method(self, _: $type) -> Out {
            Ok(stringify!($type).to_string())
        })*
    };
}

impl Serializer for Text {
    type Ok = String;
    type Error = NotInTheNotation;
    type SerializeSeq = Parts;
    type SerializeTuple = Parts;
    type SerializeTupleStruct = Never;
    type SerializeTupleVariant = Never;
    type SerializeMap = Never;
    type SerializeStruct = Parts;
    type SerializeStructVariant = Parts;

    scalars!(
        serialize_bool bool, serialize_i8 i8, serialize_i16 i16, serialize_i32 i32, serialize_i64 i64,
        serialize_u8 u8, serialize_u16 u16, serialize_u32 u32, serialize_u64 u64, serialize_f32 f32,
        serialize_f64 f64, serialize_char char
    );
    fn serialize_str(self, _: &str) -> Out {
        Err(NotInTheNotation)
    }
    fn serialize_bytes(self, _: &[u8]) -> Out {
        Err(NotInTheNotation)
    }
    fn serialize_none(self) -> Out {
        Err(NotInTheNotation)
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Out {
        Ok(format!("?{}", value.serialize(INNER)?))
    }
    fn serialize_unit(self) -> Out {
        Err(NotInTheNotation)
    }
    fn serialize_unit_struct(self, _: &'static str) -> Out {
        Err(NotInTheNotation)
    }
    fn serialize_unit_variant(self, name: &'static str, _: u32, case: &'static str) -> Out {
        Ok(if self.inner { name } else { case }.to_string())
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, _: &T) -> Out {
        Err(NotInTheNotation)
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(self, name: &'static str, _: u32, case: &'static str, value: &T) -> Out {
        if self.inner {
            return Ok(name.to_string());
        }
        Ok(format!("{case}({})", value.serialize(INNER)?))
    }
    fn serialize_seq(self, _: Option<usize>) -> Result<Parts, NotInTheNotation> {
        Ok(Parts::new("", true))
    }
    fn serialize_tuple(self, _: usize) -> Result<Parts, NotInTheNotation> {
        Ok(Parts::new("", true))
    }
    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Never, NotInTheNotation> {
        Err(NotInTheNotation)
    }
    fn serialize_tuple_variant(self, _: &'static str, _: u32, _: &'static str, _: usize) -> Result<Never, NotInTheNotation> {
        Err(NotInTheNotation)
    }
    fn serialize_map(self, _: Option<usize>) -> Result<Never, NotInTheNotation> {
        Err(NotInTheNotation)
    }
    fn serialize_struct(self, name: &'static str, _: usize) -> Result<Parts, NotInTheNotation> {
        Ok(Parts::new(name, self.inner))
    }
    fn serialize_struct_variant(
        self,
        name: &'static str,
        _: u32,
        case: &'static str,
        _: usize,
    ) -> Result<Parts, NotInTheNotation> {
        Ok(Parts::new(if self.inner { name } else { case }, self.inner))
    }
    fn collect_str<T: std::fmt::Display + ?Sized>(self, _: &T) -> Out {
        Err(NotInTheNotation)
    }
}
