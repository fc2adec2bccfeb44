//! The force envelope as an exact polygon: zonogon of the torque box, cut by half planes.

use super::ForceMap;
use crate::contact::Brush;
use nalgebra::Vector2;

/// Image of the torque box, F = offset + sum_k g_k s_k with |s_k| <= 1 and
/// g_k = limit_k (column k of the map): its corners counter-clockwise, N.
///
/// Sorted by angle in the upper half plane, the generators are the edges of the zonogon: from
/// the lowest corner, each edge 2 g_k in turn, then the same edges backwards.
pub fn zonogon(map: &ForceMap) -> Vec<Vector2<f64>> {
    let mut generators: Vec<Vector2<f64>> = map
        .per_torque
        .column_iter()
        .zip(&map.limits_n_m)
        .map(|(column, limit)| {
            let g = Vector2::new(column[0], column[1]) * *limit;
            if g[1] < 0.0 || (g[1] == 0.0 && g[0] < 0.0) {
                -g
            } else {
                g
            }
        })
        .filter(|g| g.norm() > 0.0)
        .collect();
    generators.sort_by(|a, b| a[1].atan2(a[0]).total_cmp(&b[1].atan2(b[0])));
    let mut corner = map.offset_n - generators.iter().sum::<Vector2<f64>>();
    let mut corners = Vec::with_capacity(2 * generators.len());
    for sign in [1.0, -1.0] {
        for g in &generators {
            corners.push(corner);
            corner += 2.0 * sign * g;
        }
    }
    corners
}

/// The part of a convex polygon where normal . F <= 0 (a half plane through the origin).
fn cut(corners: &[Vector2<f64>], normal: Vector2<f64>) -> Vec<Vector2<f64>> {
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (i, &here) in corners.iter().enumerate() {
        let next = corners[(i + 1) % corners.len()];
        let (d, e) = (normal.dot(&here), normal.dot(&next));
        if d <= 0.0 {
            kept.push(here);
        }
        if (d < 0.0 && e > 0.0) || (d > 0.0 && e < 0.0) {
            kept.push(here + (next - here) * (d / (d - e)));
        }
    }
    kept
}

/// Cuts a polygon by the friction cone -mu_reverse F_y <= F_x <= mu_forward F_y.
pub fn cut_by_friction(corners: &[Vector2<f64>], brush: Brush) -> Vec<Vector2<f64>> {
    let forward = cut(corners, Vector2::new(1.0, -brush.forward));
    cut(&forward, Vector2::new(-1.0, -brush.reverse))
}

/// Largest component (0: forward, 1: vertical) over the corners, N; negative infinity if empty.
pub fn largest(corners: &[Vector2<f64>], component: usize) -> f64 {
    corners
        .iter()
        .map(|corner| corner[component])
        .fold(f64::NEG_INFINITY, f64::max)
}
