//! A table as a chart, both axes logarithmic.

use crate::measure::Table;
use anyhow::Result;
use plotters::prelude::*;

const SIZE: (u32, u32) = (800, 500);
/// Told apart by the colour-blind too (Okabe and Ito 2008).
const COLORS: [RGBColor; 5] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
];

/// SVG of all columns against the first.
pub fn draw(table: &Table) -> Result<String> {
    let across = table.rows.iter().map(|r| r[0]);
    let upward = table.rows.iter().flat_map(|r| &r[1..]).copied().filter(|v| *v > 0.0);
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&area)
            .caption(table.title, ("sans-serif", 20))
            .margin(12)
            .margin_right(36)
            .x_label_area_size(40)
            .y_label_area_size(70)
            .build_cartesian_2d(decades(across).log_scale(), decades(upward).log_scale())?;
        chart.configure_mesh().x_desc(table.columns[0]).draw()?;
        for (column, color) in (1..table.columns.len()).zip(COLORS.into_iter().cycle()) {
            let points = table.rows.iter().map(|r| (r[0], r[column])).filter(|p| p.1 > 0.0);
            chart
                .draw_series(LineSeries::new(points, color.stroke_width(2)).point_size(3))?
                .label(table.columns[column])
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], color.stroke_width(2)));
        }
        let labels = SeriesLabelPosition::UpperLeft;
        chart.configure_series_labels().position(labels).background_style(WHITE).border_style(BLACK).draw()?;
        area.present()?;
    }
    Ok(svg)
}

/// Whole powers of ten around the values.
fn decades(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 1e-6), |(low, high), v| (v.min(low), v.max(high)));
    10f64.powf(low.min(high).log10().floor())..10f64.powf(high.log10().ceil() + 1e-9)
}
