//! From the columns of a file and the description of its run to a checked [`Run`] in SI units.

use std::collections::BTreeMap;

use crate::cells::{self, Columns};
use crate::description::{DIRECTIONS, Resource, RigDescription};
use crate::noise;
use crate::record::{Axis, Direction, Protocol, Run};
use crate::refusal::{Problem, Refusal};
use crate::units::{Conversion, Quantity};

/// An encoder at rest reads a little of the wrong sign: so much of the run's largest speed contradicts no direction.
/// The same share within which the contract calls two commanded velocities equal.
const SPEED_NOISE: f64 = 0.01;
/// Standard deviations of its own noise that a slow run may read of the wrong sign, and the share of its largest speed which that never exceeds.
const OWN_NOISE: f64 = 6.0;
const MOST_NOISE: f64 = 0.05;

/// A column that the program reads: its place in the header and its way to SI units.
struct Reading {
    name: String,
    index: usize,
    conversion: Conversion,
}

/// One checked run.
pub(crate) fn run(
    file: &str,
    text: &[u8],
    names: &[String],
    resource: &Resource,
    rig: &RigDescription,
) -> Result<(Axis, Run), Refusal> {
    let readings = readings(file, names, resource)?;
    let axis = axis(file, &readings)?;
    let wanted: Vec<usize> = readings.values().map(|reading| reading.index).collect();
    let read = cells::columns(file, text, resource.delimiter, names, &wanted)?;
    let mut table = Table {
        file,
        lines: &read.lines,
        readings: &readings,
        si: BTreeMap::new(),
    };
    table.convert(&read);
    let (velocity, force, position) = match axis {
        Axis::Linear => (Quantity::Velocity, Quantity::Force, Quantity::Position),
        Axis::Rotary => (Quantity::AngularVelocity, Quantity::Torque, Quantity::Angle),
    };
    table.check_time()?;
    table.check_direction(velocity, resource.direction)?;
    table.check_load(resource.protocol)?;
    let position_m = table.take(position);
    let start = start_position(axis, resource, rig, position_m.as_deref());
    Ok((
        axis,
        Run {
            name: resource.name.clone(),
            direction: resource.direction,
            protocol: resource.protocol,
            repeat: resource.repeat,
            order: resource.order,
            started_s: resource.started_s,
            normal_load_n: resource.normal_load_n,
            start_position_m: start,
            stage_turned: resource.stage_turned,
            specimen_turned: resource.specimen_turned,
            initial_state: resource.initial_state,
            velocity_m_s: table.take(velocity).unwrap_or_default(),
            force_n: table.take(force).unwrap_or_default(),
            time_s: table.take(Quantity::Time).unwrap_or_default(),
            position_m,
            normal_force_n: table.take(Quantity::NormalForce),
            temperature_c: table.take(Quantity::Temperature),
        },
    ))
}

/// The columns that hold a known quantity, each quantity once.
fn readings(
    file: &str,
    names: &[String],
    resource: &Resource,
) -> Result<BTreeMap<Quantity, Reading>, Refusal> {
    let mut readings: BTreeMap<Quantity, Reading> = BTreeMap::new();
    for field in &resource.fields {
        let Some(by_name) = Quantity::of_column(&field.name) else {
            continue;
        };
        let quantity = by_name.with_unit(field.unit.as_deref().unwrap_or_default().trim());
        // A column of the contract's own name states its unit by that name.
        let stated = field.unit.as_deref().or_else(|| {
            let (name, unit) = quantity.column();
            (name == field.name).then_some(unit)
        });
        let unit = stated.ok_or_else(|| Refusal::at_column(file, &field.name, Problem::NoUnit))?;
        let conversion = quantity
            .conversion(unit)
            .map_err(|problem| Refusal::at_column(file, &field.name, problem))?;
        // The header was checked against the schema: the name is there.
        let index = names
            .iter()
            .position(|name| *name == field.name)
            .unwrap_or_default();
        let reading = Reading {
            name: field.name.clone(),
            index,
            conversion,
        };
        if let Some(first) = readings.insert(quantity, reading) {
            let problem = Problem::DoubledQuantity {
                quantity: quantity.word(),
                first: first.name,
                second: field.name.clone(),
            };
            return Err(Refusal::of(file, problem));
        }
    }
    Ok(readings)
}

/// Linear or rotary, told by the columns; both together are refused, and so is a missing quantity.
fn axis(file: &str, readings: &BTreeMap<Quantity, Reading>) -> Result<Axis, Refusal> {
    let linear = [Quantity::Velocity, Quantity::Force, Quantity::Position];
    let rotary = [Quantity::AngularVelocity, Quantity::Torque, Quantity::Angle];
    let first_of =
        |set: [Quantity; 3]| set.into_iter().find_map(|quantity| readings.get(&quantity));
    let (axis, needed) = match (first_of(linear), first_of(rotary)) {
        (Some(one), Some(other)) => {
            let both = format!("{} and {}", one.name, other.name);
            return Err(Refusal::of(file, Problem::MixedAxes(both)));
        }
        (None, Some(_)) => (Axis::Rotary, [Quantity::Time, rotary[0], rotary[1]]),
        _ => (Axis::Linear, [Quantity::Time, linear[0], linear[1]]),
    };
    match needed
        .into_iter()
        .find(|quantity| !readings.contains_key(quantity))
    {
        Some(quantity) => Err(Refusal::of(file, Problem::MissingQuantity(quantity.word()))),
        None => Ok(axis),
    }
}

/// Where the stage stands at the first sample: as recorded, else as stated, else 0 (reverse: the end of the travel).
fn start_position(
    axis: Axis,
    resource: &Resource,
    rig: &RigDescription,
    recorded: Option<&[f64]>,
) -> f64 {
    if let Some(first) = recorded.and_then(<[f64]>::first) {
        return *first;
    }
    let (stated, travel) = match axis {
        Axis::Linear => (
            resource.start_position_mm.map(|start| start / 1000.0),
            rig.travel_mm.map(|travel| travel / 1000.0),
        ),
        Axis::Rotary => (resource.start_position_rad, rig.travel_rad),
    };
    stated.unwrap_or(match resource.direction {
        Direction::Reverse => travel.unwrap_or(0.0),
        Direction::Forward | Direction::Both => 0.0,
    })
}

/// Columns in SI units with what is needed to name one of their cells.
struct Table<'a> {
    file: &'a str,
    lines: &'a [usize],
    readings: &'a BTreeMap<Quantity, Reading>,
    si: BTreeMap<Quantity, Vec<f64>>,
}

impl Table<'_> {
    /// Every column to SI units: the only place where units are converted.
    fn convert(&mut self, read: &Columns) {
        for ((quantity, reading), column) in self.readings.iter().zip(&read.values) {
            let si = column
                .iter()
                .map(|written| reading.conversion.to_si(*written))
                .collect();
            self.si.insert(*quantity, si);
        }
    }

    fn column(&self, quantity: Quantity) -> &[f64] {
        self.si.get(&quantity).map_or(&[], Vec::as_slice)
    }

    fn take(&mut self, quantity: Quantity) -> Option<Vec<f64>> {
        self.si.remove(&quantity)
    }

    fn refuse(&self, quantity: Quantity, sample: usize, problem: Problem) -> Refusal {
        let name = self
            .readings
            .get(&quantity)
            .map_or("", |reading| reading.name.as_str());
        Refusal::at_cell(self.file, self.lines[sample], name, problem)
    }

    /// Time increases strictly; gaps are allowed.
    fn check_time(&self) -> Result<(), Refusal> {
        let time = self.column(Quantity::Time);
        match time.windows(2).position(|pair| pair[1] <= pair[0]) {
            None => Ok(()),
            Some(index) => {
                let problem = Problem::TimeOrder {
                    before: time[index],
                    now: time[index + 1],
                };
                Err(self.refuse(Quantity::Time, index + 1, problem))
            }
        }
    }

    /// No velocity of a sign that the direction excludes.
    fn check_direction(&self, quantity: Quantity, direction: Direction) -> Result<(), Refusal> {
        let velocity = self.column(quantity);
        let largest = velocity
            .iter()
            .fold(0.0_f64, |largest, v| largest.max(v.abs()));
        let fours = (self.column(Quantity::Time).windows(4)).zip(velocity.windows(4));
        let own = OWN_NOISE * noise::of_third_differences(fours);
        let allowed = own.clamp(SPEED_NOISE * largest, MOST_NOISE * largest);
        let wrong = |v: f64| match direction {
            Direction::Forward => v < -allowed,
            Direction::Reverse => v > allowed,
            Direction::Both => false,
        };
        match velocity.iter().position(|v| wrong(*v)) {
            None => Ok(()),
            Some(sample) => {
                let word = DIRECTIONS.iter().find(|(_, known)| *known == direction);
                let unit = if quantity == Quantity::Velocity {
                    "m/s"
                } else {
                    "rad/s"
                };
                let problem = Problem::Direction {
                    direction: word.map_or("", |(word, _)| *word),
                    velocity: format!("{} {unit}", velocity[sample]),
                };
                Err(self.refuse(quantity, sample, problem))
            }
        }
    }

    /// A recorded load is above zero, except without contact.
    fn check_load(&self, protocol: Protocol) -> Result<(), Refusal> {
        if protocol == Protocol::Unloaded {
            return Ok(());
        }
        let load = self.column(Quantity::NormalForce);
        match load.iter().position(|n| *n <= 0.0) {
            None => Ok(()),
            Some(sample) => {
                let n = load[sample];
                let problem = if n < 0.0 {
                    Problem::NegativeLoad(n)
                } else {
                    Problem::ZeroLoad
                };
                Err(self.refuse(Quantity::NormalForce, sample, problem))
            }
        }
    }
}
