//! Regions of space on the command line.

use nalgebra::Point3;
use ppnpack_recognition::segmentation::Region;

use crate::length::parse_coordinate;

/// Parses a box by its lowest and its highest corner, `X,Y,Z,X,Y,Z`; gives metres.
pub(crate) fn parse_region(text: &str) -> Result<Region, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(parse_coordinate)
        .collect::<Result<_, _>>()?;
    let [x0, y0, z0, x1, y1, z1] = <[f64; 6]>::try_from(numbers).map_err(|_| {
        format!("'{text}' is no region: its lowest and its highest corner are needed, X,Y,Z,X,Y,Z")
    })?;
    let region = Region {
        lowest_m: Point3::new(x0, y0, z0),
        highest_m: Point3::new(x1, y1, z1),
    };
    let sides = region.highest_m - region.lowest_m;
    if sides.iter().all(|side_m| *side_m > 0.0) {
        Ok(region)
    } else {
        Err(format!(
            "'{text}' is no region: the second corner must be higher along each axis"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_region_has_two_corners() {
        let region = parse_region("-36cm,-0.7,-40mm, 40cm,-6cm,0.35").unwrap();
        assert_eq!(region.lowest_m, Point3::new(-0.36, -0.7, -0.04));
        assert_eq!(region.highest_m, Point3::new(0.4, -0.06, 0.35));
        for wrong in ["1,2,3", "0,0,0,1,1,0", "0,0,0,1,1,x", ""] {
            assert!(parse_region(wrong).is_err(), "{wrong}");
        }
    }
}
