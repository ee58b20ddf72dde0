//! Tables as Parquet: required columns, plain encoding without compression, one row group; readable by everything.

use super::Column;
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::sync::Arc;

/// The bytes of a file.
pub(super) fn write(columns: &[(String, Column)]) -> Result<Vec<u8>> {
    let field = |(name, column): &(String, Column)| {
        let (physical, logical) = match column {
            Column::Whole(_) => (Physical::INT64, Some(LogicalType::integer(64, true))),
            Column::Number(_) => (Physical::DOUBLE, None),
            Column::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let builder = Type::primitive_type_builder(name, physical).with_repetition(Repetition::REQUIRED);
        builder.with_logical_type(logical).build().map(Arc::new)
    };
    let fields = columns.iter().map(field).collect::<Result<_>>()?;
    let schema = Arc::new(Type::group_type_builder("sweep").with_fields(fields).build()?);
    let properties = WriterProperties::builder().set_created_by("gonio".to_owned()).set_dictionary_enabled(false);
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties.build()))?;
    let mut group = writer.next_row_group()?;
    for (_, column) in columns {
        let missing = || ParquetError::General("a column is missing".to_owned());
        let mut out = group.next_column()?.ok_or_else(missing)?;
        match column {
            Column::Whole(values) => {
                let values: Vec<i64> = values.iter().map(|v| i64::try_from(*v).unwrap_or(i64::MAX)).collect();
                out.typed::<Int64Type>().write_batch(&values, None, None)?;
            }
            Column::Number(values) => {
                out.typed::<DoubleType>().write_batch(values, None, None)?;
            }
            Column::Text(values) => {
                let values: Vec<ByteArray> = values.iter().map(|v| ByteArray::from(v.as_str())).collect();
                out.typed::<ByteArrayType>().write_batch(&values, None, None)?;
            }
        }
        out.close()?;
    }
    group.close()?;
    writer.into_inner()
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    #[test]
    fn the_table_reads_back() {
        let columns = [
            ("material.shell.roughness".to_owned(), Column::Number(vec![0.1, f64::MIN_POSITIVE])),
            ("frame".to_owned(), Column::Whole(vec![0, u64::MAX >> 1])),
            ("view".to_owned(), Column::Text(vec!["dome-000".to_owned(), "é".to_owned()])),
        ];
        let bytes = write(&columns).unwrap();
        assert_eq!(bytes, write(&columns).unwrap());
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        let rows: Vec<Vec<(String, Field)>> = reader
            .get_row_iter(None)
            .unwrap()
            .map(|row| row.unwrap().get_column_iter().map(|(n, f)| (n.clone(), f.clone())).collect())
            .collect();
        let row = |number, whole, text: &str| {
            vec![
                ("material.shell.roughness".to_owned(), Field::Double(number)),
                ("frame".to_owned(), Field::Long(whole)),
                ("view".to_owned(), Field::Str(text.to_owned())),
            ]
        };
        assert_eq!(rows, [row(0.1, 0, "dome-000"), row(f64::MIN_POSITIVE, i64::MAX, "é")]);
    }
}
