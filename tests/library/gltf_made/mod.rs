//! Small glTF files made here, one question each: values that change, bodies that bend,
//! cameras of every kind.

mod bending;
mod cameras;
mod file;
mod instances;
mod materials;
mod pointers;
