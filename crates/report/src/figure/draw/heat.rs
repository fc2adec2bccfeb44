//! Maps and matrices: one cell a combination, a colour scale beside them, level curves between cell centres.

use super::super::{HeatMap, Scale};
use super::canvas::{FONT, Paint, SCALE};
use super::frame::{Frame, axis_name};
use super::lines::checked;
use super::ruler::{Ruler, limits_of};
use super::sheet::{Anchor, Drawn, Sheet};
use super::thin::Place;
use crate::number;
use crate::palette::{LEVELS, needs_pale_words};

/// Room for the colour scale.
const SCALE_ROOM: i32 = 86 * SCALE;
/// Room for the colour scale's name, above all cells.
const NAME_ROOM: i32 = 22 * SCALE;
/// Least height of the cells: an axis' name of thirty letters stands along it.
const LEAST: i32 = 200 * SCALE;

/// Draws the map into `out`; the height of the sheet comes back.
pub(super) fn draw(map: &HeatMap, synthetic: bool, out: &mut String) -> Result<i32, String> {
    if map.rows.is_empty() || map.columns.is_empty() {
        return Err("a map without cells".into());
    }
    if map.values.len() != map.rows.len()
        || map.values.iter().any(|row| row.len() != map.columns.len())
    {
        return Err(format!(
            "the cells are not {} rows of {}",
            map.rows.len(),
            map.columns.len()
        ));
    }
    let rows = i32::try_from(map.rows.len()).unwrap_or(i32::MAX);
    let cells = (rows.min(40) * 34 * SCALE).clamp(LEAST, 460 * SCALE);
    let height = cells + 62 * SCALE + NAME_ROOM + super::stamp_height(synthetic);
    let sheet = Sheet::new(out, height);
    let colours = Colours::of(map)?;
    paint(map, &sheet, &colours, synthetic).map_err(|error| error.to_string())?;
    Ok(height)
}

/// The colour scale: from a number to a level.
struct Colours {
    low: f64,
    high: f64,
    diverging: bool,
}

impl Colours {
    fn of(map: &HeatMap) -> Result<Self, String> {
        let numbers = map.values.iter().flatten().flatten().copied();
        let given = map
            .limits
            .or_else(|| limits_of(numbers, Scale::Linear, false));
        let [low, high] = checked(given, Scale::Linear)?;
        Ok(match map.centre {
            Some(centre) => {
                let reach = (high - centre).abs().max((centre - low).abs());
                Self {
                    low: centre - reach,
                    high: centre + reach,
                    diverging: true,
                }
            }
            None => Self {
                low,
                high,
                diverging: false,
            },
        })
    }

    fn level(&self, number: f64) -> u8 {
        let share = ((number - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 0 and LEVELS
        let level = (share * f64::from(LEVELS)).round() as u8;
        level
    }

    fn paint(&self, level: u8) -> Paint {
        if self.diverging {
            Paint::Diverging(level)
        } else {
            Paint::Sequential(level)
        }
    }

    fn pale_words(&self, level: u8) -> bool {
        needs_pale_words(self.diverging, level)
    }
}

fn paint(map: &HeatMap, sheet: &Sheet<'_>, colours: &Colours, synthetic: bool) -> Drawn {
    let mut rows = map.rows.clone();
    rows.reverse();
    let rulers = (
        Ruler::categories(&thinned(&map.columns)),
        Ruler::categories(&rows),
    );
    let names = (axis_name(&map.x), axis_name(&map.y));
    let frame = Frame::draw(
        sheet,
        rulers,
        (&names.0, &names.1),
        (super::stamp_height(synthetic) + NAME_ROOM, SCALE_ROOM),
        false,
    )?;
    #[allow(clippy::cast_precision_loss)] // a handful of cells
    let centre = |row: usize, column: usize| [column as f64, (map.rows.len() - 1 - row) as f64];
    for (row, cells) in map.values.iter().enumerate() {
        for (column, cell) in cells.iter().enumerate() {
            let [x, y] = centre(row, column);
            let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
                .map(|[dx, dy]| frame.place([x + dx, y + dy]));
            let Some(number) = cell.filter(|number| number.is_finite()) else {
                sheet.area(&corners, Paint::Absent)?;
                sheet.line(&[corners[0], corners[2]], Paint::Rule, 8)?;
                continue;
            };
            let level = colours.level(number);
            sheet.area(&corners, colours.paint(level))?;
            if map.numbers {
                let text = number::significant(number, 3);
                sheet.text(
                    &text,
                    frame.place([x, y]),
                    Anchor::Middle,
                    Paint::OnCell(colours.pale_words(level)),
                    FONT - 10,
                )?;
            }
        }
    }
    for (level, label) in &map.levels {
        draw_level(map, *level, label, sheet, &frame)?;
    }
    draw_scale(map, colours, sheet, &frame)?;
    if synthetic {
        frame.stamp(sheet)?;
    }
    Ok(())
}

/// Labels of many columns would run into each other: about ten stay.
fn thinned(names: &[String]) -> Vec<String> {
    let longest = names
        .iter()
        .map(|name| name.chars().count())
        .max()
        .unwrap_or(1);
    let fits = (76 / (longest + 2)).max(2);
    let stride = names.len().div_ceil(fits);
    names
        .iter()
        .enumerate()
        .map(|(index, name)| {
            if index % stride == 0 {
                name.clone()
            } else {
                String::new()
            }
        })
        .collect()
}

/// The colour scale right of the cells.
fn draw_scale(map: &HeatMap, colours: &Colours, sheet: &Sheet<'_>, frame: &Frame) -> Drawn {
    let [_, top, right, bottom] = frame.edges;
    let (left, width) = (right + 220.0, 140.0);
    let step = (bottom - top) / f64::from(LEVELS + 1);
    for level in 0..=LEVELS {
        let low = bottom - f64::from(level) * step;
        let corners = [
            [left, low],
            [left + width, low],
            [left + width, low - step - 2.0],
            [left, low - step - 2.0],
        ];
        sheet.area(&corners, colours.paint(level))?;
    }
    let ruler = Ruler::new([colours.low, colours.high], Scale::Linear, 5);
    for (tick, label) in ruler.ticks() {
        let share = (tick - colours.low) / (colours.high - colours.low);
        let y = bottom - share * (bottom - top);
        sheet.text(
            label,
            [left + width + 50.0, y],
            Anchor::Left,
            Paint::Text,
            FONT - 10,
        )?;
    }
    let name = match number::unit(&map.unit).as_str() {
        "" => map.quantity.clone(),
        unit => format!("{} ({unit})", map.quantity),
    };
    sheet.text(
        &name,
        [f64::from(super::sheet::WIDTH) - 20.0, top - 100.0],
        Anchor::Right,
        Paint::Text,
        FONT - 10,
    )
}

/// The curve where the map, linear between cell centres, has this level (marching squares).
fn draw_level(map: &HeatMap, level: f64, label: &str, sheet: &Sheet<'_>, frame: &Frame) -> Drawn {
    let mut labelled = false;
    for row in 0..map.rows.len().saturating_sub(1) {
        for column in 0..map.columns.len().saturating_sub(1) {
            let corners = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(down, along)| {
                let (r, c) = (row + down, column + along);
                #[allow(clippy::cast_precision_loss)] // a handful of cells
                let place = frame.place([c as f64, (map.rows.len() - 1 - r) as f64]);
                (place, map.values[r][c])
            });
            let crossings: Vec<Place> = (0..4)
                .filter_map(|edge| {
                    let (from, to) = (corners[edge], corners[(edge + 1) % 4]);
                    let (a, b) = (from.1? - level, to.1? - level);
                    let crosses = (a < 0.0) != (b < 0.0);
                    let share = a / (a - b);
                    crosses.then(|| {
                        [
                            from.0[0] + share * (to.0[0] - from.0[0]),
                            from.0[1] + share * (to.0[1] - from.0[1]),
                        ]
                    })
                })
                .collect();
            for pair in crossings.chunks_exact(2) {
                sheet.line(pair, Paint::Text, 22)?;
                if !labelled {
                    sheet.text(
                        label,
                        [pair[0][0], pair[0][1] - 40.0],
                        Anchor::Above,
                        Paint::Text,
                        FONT - 10,
                    )?;
                    labelled = true;
                }
            }
        }
    }
    Ok(())
}
