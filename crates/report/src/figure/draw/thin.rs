//! Fewer points for the same picture: clipping to the frame, and leaving out what no eye can see.

/// A point on the canvas, in canvas units but not yet rounded.
pub(super) type Place = [f64; 2];

/// Splits a line into the parts inside the frame `[x0, y0, x1, y1]`.
pub(super) fn clip_line(points: &[Place], frame: [f64; 4]) -> Vec<Vec<Place>> {
    let mut parts: Vec<Vec<Place>> = Vec::new();
    let mut part: Vec<Place> = Vec::new();
    for pair in points.windows(2) {
        let finite = pair.iter().flatten().all(|number| number.is_finite());
        let Some([from, to]) = finite
            .then(|| clip_segment(pair[0], pair[1], frame))
            .flatten()
        else {
            parts.extend((part.len() > 1).then(|| std::mem::take(&mut part)));
            part.clear();
            continue;
        };
        if part.last() != Some(&from) {
            parts.extend((part.len() > 1).then(|| std::mem::take(&mut part)));
            part = vec![from];
        }
        part.push(to);
    }
    parts.extend((part.len() > 1).then_some(part));
    parts
}

/// The part of a segment inside the frame (Liang and Barsky).
fn clip_segment(from: Place, to: Place, [x0, y0, x1, y1]: [f64; 4]) -> Option<[Place; 2]> {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (slope, distance) in [
        (-dx, from[0] - x0),
        (dx, x1 - from[0]),
        (-dy, from[1] - y0),
        (dy, y1 - from[1]),
    ] {
        if slope == 0.0 {
            if distance < 0.0 {
                return None;
            }
        } else if slope < 0.0 {
            enter = enter.max(distance / slope);
        } else {
            leave = leave.min(distance / slope);
        }
    }
    let at = |share: f64| [from[0] + share * dx, from[1] + share * dy];
    (enter <= leave).then(|| {
        [
            if enter > 0.0 { at(enter) } else { from },
            if leave < 1.0 { at(leave) } else { to },
        ]
    })
}

/// The part of a polygon inside the frame (Sutherland and Hodgman).
pub(super) fn clip_polygon(corners: &[Place], [x0, y0, x1, y1]: [f64; 4]) -> Vec<Place> {
    let mut kept = corners.to_vec();
    for (axis, bound, sign) in [(0, x0, 1.0), (0, x1, -1.0), (1, y0, 1.0), (1, y1, -1.0)] {
        let before = std::mem::take(&mut kept);
        for (index, &to) in before.iter().enumerate() {
            let from = before[(index + before.len() - 1) % before.len()];
            let (inside_from, inside_to) = (sign * (from[axis] - bound), sign * (to[axis] - bound));
            if (inside_from >= 0.0) != (inside_to >= 0.0) {
                let share = inside_from / (inside_from - inside_to);
                kept.push([
                    from[0] + share * (to[0] - from[0]),
                    from[1] + share * (to[1] - from[1]),
                ]);
            }
            if inside_to >= 0.0 {
                kept.push(to);
            }
        }
    }
    kept
}

/// A line with the points left out that no eye can see: within each column of `column` units only first, lowest,
/// highest and last stay; then whatever lies within `tolerance` of the line through its neighbours goes.
pub(super) fn thin_line(points: &[Place], column: f64, tolerance: f64) -> Vec<Place> {
    let monotone = points.windows(2).all(|pair| pair[0][0] <= pair[1][0]);
    let reduced = if monotone && points.len() > 64 {
        reduce_columns(points, column)
    } else {
        points.to_vec()
    };
    simplify(&reduced, tolerance)
}

fn reduce_columns(points: &[Place], column: f64) -> Vec<Place> {
    let mut out = Vec::new();
    let mut start = 0;
    while start < points.len() {
        let end = points[start..]
            .iter()
            .position(|point| point[0] >= points[start][0] + column)
            .map_or(points.len(), |offset| start + offset.max(1));
        let indices = start..end;
        let lowest = indices
            .clone()
            .min_by(|&a, &b| points[a][1].total_cmp(&points[b][1]));
        let highest = indices
            .clone()
            .max_by(|&a, &b| points[a][1].total_cmp(&points[b][1]));
        let mut keep: Vec<usize> = [Some(start), lowest, highest, Some(end - 1)]
            .into_iter()
            .flatten()
            .collect();
        keep.sort_unstable();
        keep.dedup();
        out.extend(keep.into_iter().map(|index| points[index]));
        start = end;
    }
    out
}

/// Ramer, Douglas and Peucker, without recursion.
fn simplify(points: &[Place], tolerance: f64) -> Vec<Place> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut keep = vec![false; points.len()];
    keep[0] = true;
    keep[points.len() - 1] = true;
    let mut stack = vec![(0, points.len() - 1)];
    while let Some((first, last)) = stack.pop() {
        let farthest = (first + 1..last)
            .map(|index| (index, distance(points[index], points[first], points[last])))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, far)) = farthest
            && far > tolerance
        {
            keep[index] = true;
            stack.push((first, index));
            stack.push((index, last));
        }
    }
    points
        .iter()
        .zip(keep)
        .filter_map(|(point, keep)| keep.then_some(*point))
        .collect()
}

/// Distance of a point from a segment.
fn distance(point: Place, from: Place, to: Place) -> f64 {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx * dx + dy * dy;
    let share = if length == 0.0 {
        0.0
    } else {
        (((point[0] - from[0]) * dx + (point[1] - from[1]) * dy) / length).clamp(0.0, 1.0)
    };
    (point[0] - from[0] - share * dx).hypot(point[1] - from[1] - share * dy)
}

/// At most `most` of the items, evenly chosen, always with the first and the last.
pub(crate) fn evenly<T: Copy>(items: &[T], most: usize) -> Vec<T> {
    if items.len() <= most || most < 2 {
        return items.to_vec();
    }
    (0..most)
        .map(|index| items[index * (items.len() - 1) / (most - 1)])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: [f64; 4] = [0.0, 0.0, 10.0, 10.0];

    #[test]
    fn a_line_that_leaves_and_returns_has_two_parts() {
        let line = [[1.0, 5.0], [1.0, 15.0], [5.0, 15.0], [5.0, 5.0]];
        let parts = clip_line(&line, FRAME);
        assert_eq!(
            parts,
            vec![vec![[1.0, 5.0], [1.0, 10.0]], vec![[5.0, 10.0], [5.0, 5.0]]]
        );
    }

    #[test]
    fn a_gap_breaks_the_line() {
        let line = [
            [1.0, 1.0],
            [2.0, 1.0],
            [f64::NAN, 1.0],
            [3.0, 1.0],
            [4.0, 1.0],
        ];
        assert_eq!(clip_line(&line, FRAME).len(), 2);
    }

    #[test]
    fn a_polygon_is_cut_at_the_frame() {
        let cut = clip_polygon(&[[5.0, 5.0], [15.0, 5.0], [15.0, 15.0], [5.0, 15.0]], FRAME);
        assert_eq!(cut.len(), 4);
        assert!(
            cut.iter()
                .flatten()
                .all(|number| (5.0..=10.0).contains(number))
        );
    }

    #[test]
    fn thinning_keeps_extremes() {
        let noisy: Vec<Place> = (0..5000)
            .map(|k| {
                let k = f64::from(k);
                [k, if k == 1234.0 { 99.0 } else { (k * 1.7).sin() }]
            })
            .collect();
        let thin = thin_line(&noisy, 20.0, 0.5);
        assert!(thin.len() < 1200);
        assert!(thin.contains(&[1234.0, 99.0]));
        assert_eq!(
            thin_line(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], 1.0, 0.1).len(),
            2
        );
        assert_eq!(evenly(&[1, 2, 3, 4, 5], 3), [1, 3, 5]);
    }
}
