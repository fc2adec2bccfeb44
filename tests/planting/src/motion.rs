//! Motions of the stage: speed as a chain of linear pieces, positions by exact integration.

/// One piece: the speed runs linearly from `v0` at `t0` to `v1` at `t1` (s, m/s or rad/s).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    t0: f64,
    t1: f64,
    v0: f64,
    v1: f64,
    x0: f64,
}

/// How a play stands: the direction in which it is taken up (0: of the next motion), the distance over which it still holds after
/// a turn before it opens, and the distance then to cross before the follower moves, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Play {
    heading: f64,
    held: f64,
    slack: f64,
}

/// A motion of the stage from t = 0; after its end the last speed is held, before its start it rests.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    pieces: Vec<Piece>,
}

impl Motion {
    /// The motion through the points (time, speed), starting at time 0 and position 0.
    ///
    /// # Panics
    /// If there are fewer than two points or times do not increase.
    pub fn through(points: &[(f64, f64)]) -> Self {
        assert!(points.len() >= 2, "a motion needs two points");
        let mut pieces = Vec::new();
        let mut x0 = 0.0;
        for pair in points.windows(2) {
            let [(t0, v0), (t1, v1)] = [pair[0], pair[1]];
            assert!(t1 > t0, "times of a motion increase");
            pieces.push(Piece { t0, t1, v0, v1, x0 });
            x0 += 0.5 * (v0 + v1) * (t1 - t0);
        }
        Self { pieces }
    }

    /// End of the last piece, s.
    pub fn duration_s(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.t1)
    }

    fn piece(&self, time_s: f64) -> &Piece {
        let index = self.pieces.partition_point(|piece| piece.t1 <= time_s);
        &self.pieces[index.min(self.pieces.len() - 1)]
    }

    /// Speed at `time_s`.
    pub fn speed(&self, time_s: f64) -> f64 {
        let piece = self.piece(time_s);
        let share = ((time_s - piece.t0) / (piece.t1 - piece.t0)).clamp(0.0, 1.0);
        piece.v0 + share * (piece.v1 - piece.v0)
    }

    /// Speed at `time_s` taken from the piece that holds `inside_s`: one-sided values at a jump.
    pub fn speed_within(&self, time_s: f64, inside_s: f64) -> f64 {
        let piece = self.piece(inside_s);
        let share = ((time_s - piece.t0) / (piece.t1 - piece.t0)).clamp(0.0, 1.0);
        piece.v0 + share * (piece.v1 - piece.v0)
    }

    /// When the motion first turns, s; never: infinite.
    pub fn turns_at_s(&self) -> f64 {
        let mut way = 0.0;
        for piece in &self.pieces {
            if way * piece.v1 < 0.0 {
                let share = piece.v0.abs() / (piece.v0.abs() + piece.v1.abs());
                return piece.t0 + share * (piece.t1 - piece.t0);
            }
            if piece.v1 != 0.0 {
                way = piece.v1;
            }
        }
        f64::INFINITY
    }

    /// Mean acceleration over `half_window_s` either way: no stage changes its acceleration in no time.
    pub fn acceleration(&self, time_s: f64, half_window_s: f64) -> f64 {
        let before = if time_s < half_window_s {
            0.0
        } else {
            self.speed(time_s - half_window_s)
        };
        (self.speed(time_s + half_window_s) - before) / (2.0 * half_window_s)
    }

    /// Distance from the start at `time_s`, signed.
    pub fn position(&self, time_s: f64) -> f64 {
        let piece = self.piece(time_s);
        let since = (time_s.min(piece.t1) - piece.t0).max(0.0);
        let slope = (piece.v1 - piece.v0) / (piece.t1 - piece.t0);
        let held = (time_s - piece.t1).max(0.0) * piece.v1;
        piece.x0 + since * (piece.v0 + 0.5 * slope * since) + held
    }

    /// Times where the speed has a kink, a jump or a change of sign, in order.
    pub fn breakpoints(&self) -> Vec<f64> {
        let mut times = Vec::new();
        for piece in &self.pieces {
            times.push(piece.t0);
            if piece.v0 * piece.v1 < 0.0 {
                let crossing = piece.t0 + (piece.t1 - piece.t0) * piece.v0 / (piece.v0 - piece.v1);
                // A crossing within a nanosecond of an end is that end, rounded.
                if crossing > piece.t0 + 1e-9 && crossing < piece.t1 - 1e-9 {
                    times.push(crossing);
                }
            }
        }
        times.push(self.duration_s());
        times
    }

    /// The motion behind a play of width `gap`: after every reversal it rests until the gap is crossed. The gap opens where the motion
    /// turns, or after the next of the distances `held` (m) from there. `play` is how it stands before the motion and takes how it
    /// stands after it.
    pub fn behind_play(&self, gap: f64, held: &[f64], play: &mut Play) -> Self {
        let mut points: Vec<Piece> = Vec::new();
        let mut x = 0.0;
        let mut held = held.iter().copied();
        let mut push = |(t0, v0): (f64, f64), (t1, v1): (f64, f64)| {
            if t1 > t0 {
                points.push(Piece {
                    t0,
                    t1,
                    v0,
                    v1,
                    x0: x,
                });
                x += 0.5 * (v0 + v1) * (t1 - t0);
            }
        };
        let edges = self.breakpoints();
        for pair in edges.windows(2) {
            let inside = 0.5 * (pair[0] + pair[1]);
            let [start, end] = [pair[0], pair[1]].map(|t| (t, self.speed_within(t, inside)));
            let sum = start.1 + end.1;
            if sum == 0.0 {
                push((start.0, 0.0), (end.0, 0.0));
                continue;
            }
            play.turn(sum.signum(), gap, || held.next().unwrap_or(0.0));
            let opens = after(start, end, &mut play.held);
            push(start, opens);
            let closes = after(opens, end, &mut play.slack);
            push((opens.0, 0.0), (closes.0, 0.0));
            push(closes, end);
        }
        Self { pieces: points }
    }

    /// Times at which the motion turns.
    pub fn turns(&self) -> Vec<f64> {
        let mut turns = Vec::new();
        let mut heading = 0.0;
        for pair in self.breakpoints().windows(2) {
            let sign = self.speed(0.5 * (pair[0] + pair[1]));
            if heading * sign < 0.0 {
                turns.push(pair[0]);
            }
            if sign != 0.0 {
                heading = sign;
            }
        }
        turns
    }
}

impl Play {
    /// Motion with this sign follows; `held`: the distance over which a play that is taken up holds after a turn.
    fn turn(&mut self, sign: f64, gap: f64, held: impl FnOnce() -> f64) {
        if sign == self.heading {
            return;
        }
        if self.held > 0.0 {
            // It had not opened: the same side pulls again.
            self.held = 0.0;
            self.slack = 0.0;
        } else if self.heading != 0.0 {
            if self.slack == 0.0 {
                self.held = held();
            }
            self.slack = gap - self.slack;
        }
        self.heading = sign;
    }
}

/// (time, speed) at which `way` is gone between two points of one piece, or the end of it; `way` takes what is left.
fn after(start: (f64, f64), end: (f64, f64), way: &mut f64) -> (f64, f64) {
    let ((t0, v0), (t1, v1)) = (start, end);
    let travel = 0.5 * (v0 + v1).abs() * (t1 - t0);
    if travel <= *way {
        *way -= travel;
        return end;
    }
    if *way == 0.0 {
        return start;
    }
    // way = |v0| u + a u^2 / 2 with a = (|v1| - |v0|)/(t1 - t0)
    let a = (v1.abs() - v0.abs()) / (t1 - t0);
    let u = 2.0 * *way / (v0.abs() + (v0 * v0 + 2.0 * a * *way).max(0.0).sqrt());
    *way = 0.0;
    (t0 + u, v0 + (v1 - v0) * u / (t1 - t0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramp_covers_half_of_its_end_speed_times_its_duration() {
        let ramp = Motion::through(&[(0.0, 0.0), (10.0, 0.06)]);
        assert!((ramp.position(10.0) - 0.3).abs() < 1e-15);
        assert!((ramp.speed(5.0) - 0.03).abs() < 1e-15);
        assert!((ramp.acceleration(5.0, 0.01) - 0.006).abs() < 1e-13);
    }

    /// A follower behind a play loses exactly one gap for each reversal.
    #[test]
    fn play_costs_one_gap_a_reversal() {
        let there_and_back = Motion::through(&[
            (0.0, 0.0),
            (1.0, 0.02),
            (2.0, -0.02),
            (3.0, -0.02),
            (4.0, 0.0),
            (5.0, 0.01),
        ]);
        let mut play = Play::default();
        let behind = there_and_back.behind_play(1e-3, &[], &mut play);
        let expected = there_and_back.position(5.0);
        // One reversal loses +gap, the second gives it back.
        assert!((behind.position(5.0) - expected).abs() < 1e-12);
        assert!((behind.position(3.5) - (there_and_back.position(3.5) + 1e-3)).abs() < 1e-12);
        // It ended forward with the play taken up: forward again nothing is lost, in reverse the gap is crossed anew.
        let on = Motion::through(&[(0.0, 0.0), (1.0, 0.02)]);
        let back = Motion::through(&[(0.0, 0.0), (1.0, -0.02)]);
        assert_eq!(on.behind_play(1e-3, &[], &mut play), on);
        assert!(
            (back.behind_play(1e-3, &[], &mut play).position(1.0) - (back.position(1.0) + 1e-3))
                .abs()
                < 1e-12
        );
    }
    /// A play that holds for a while loses its gap later, and none where the motion turns again before it opens.
    #[test]
    fn play_that_holds_opens_later() {
        let turns_twice = |back_s: f64| {
            Motion::through(&[
                (0.0, 0.01),
                (1.0, 0.01),
                (1.0 + 1e-9, -0.01),
                (1.0 + back_s, -0.01),
                (1.0 + back_s + 1e-9, 0.01),
                (4.0, 0.01),
            ])
        };
        let behind = |motion: &Motion| {
            let mut play = Play::default();
            motion.behind_play(1e-3, &[5e-4, 5e-4], &mut play)
        };
        let long = turns_twice(1.0);
        assert_eq!(long.turns().len(), 2);
        // 0.5 mm are followed, 1 mm is lost.
        let at = |time: f64| behind(&long).position(time) - long.position(time);
        assert!(at(1.049).abs() < 1e-9, "{}", at(1.049));
        assert!((at(1.1) - 0.5e-3).abs() < 1e-8, "{}", at(1.1));
        assert!((at(1.9) - 1e-3).abs() < 1e-8, "{}", at(1.9));
        assert!(at(3.9).abs() < 1e-8, "{}", at(3.9));
        let short = turns_twice(0.04);
        assert!((behind(&short).position(4.0) - short.position(4.0)).abs() < 1e-9);
    }
}
