//! One look at the level of radar cells: scatterers in a window of cells instead of a closed centroid.

use super::{Asde, Draws, Return};
use crate::draw::DrawKey;
use crate::effects::radar::{RadarEffect, RadarLevels};
use crate::frames::{Azimuth, wrap_pi};
use crate::plot::{Plot, Polar};
use crate::sensors::Truth;
use crate::sensors::detection::{Swerling, to_db};
use crate::sensors::extended;
use crate::sensors::video::{CellWork, Fading, PointEcho, point_echoes};

impl Asde {
    /// Detects and measures the echoes that share a cell with the `index`-th, in their cells: the
    /// strongest cluster is the plot. Fading, noise, threshold and centroid are those of the cells;
    /// only the stated deviations are the plot level's.
    pub(super) fn measure_cells(
        &mut self,
        levels: &RadarLevels,
        truth: &dyn Truth,
        returns: &[Return],
        index: u32,
        key: DrawKey,
        work: &mut CellWork,
    ) -> Option<(Plot, Draws)> {
        self.tally.count(RadarEffect::Detection);
        let head = &returns[index as usize];
        let members = || returns.iter().enumerate().filter(|(_, r)| r.cell == index);
        // Merging has added the others' signals to the first one's.
        let others: f64 =
            members().filter(|(i, _)| *i as u32 != index).map(|(_, r)| r.budget.signal_w).sum();
        let mut echoes: Vec<PointEcho> = Vec::with_capacity(extended::MAX_ECHOES);
        for (i, r) in members() {
            let own_w = r.budget.signal_w - if i as u32 == index { others } else { 0.0 };
            let offset = r.look.state.position_m.xy() - self.site_m;
            let azimuth_rad = Azimuth::of(offset).rad();
            let view = extended::view_rad(azimuth_rad, r.look.state.heading_rad);
            let scatterers = extended::echoes(truth.class(r.look.index), view);
            let snr = own_w.max(0.0) / r.budget.noise_w;
            let ground_m = offset.norm();
            echoes.extend(point_echoes(&scatterers, r.budget.range_m, azimuth_rad, ground_m, snr));
        }
        // Beyond the unambiguous range the echo appears nearer, with all its scatterers.
        let shift_m = head.budget.range_m - self.apparent_m(levels, head.budget.range_m)?;
        echoes.iter_mut().for_each(|e| e.range_m -= shift_m);
        let budget = &head.budget;
        let clutter_w = budget.rain_w * self.parameters.rain_correlation() + budget.ground_w;
        let background = 1.0 + clutter_w / budget.noise_w;
        let fading = match self.parameters.swerling {
            Swerling::Steady => Fading::Steady,
            _ => Fading::Independent,
        };
        let blob = *self.grid.window(&echoes, background, fading, key, work).first()?;
        let (thermal_range_m, thermal_azimuth_rad) = self.sigmas(budget.scnr(), budget.reflected);
        let ground_m = budget.range_m.max(1.0);
        let draws = Draws {
            range_m: 0.0,
            azimuth_rad: 0.0,
            glint_along_m: blob.range_m + shift_m - head.range_m,
            glint_across_m: wrap_pi(blob.azimuth_rad - head.azimuth_rad) * ground_m,
        };
        let measured = Polar {
            range_m: blob.range_m,
            azimuth_rad: blob.azimuth_rad,
            sigma_range_m: libm::hypot(thermal_range_m, head.glint_along_m),
            sigma_azimuth_rad: libm::hypot(thermal_azimuth_rad, head.glint_across_m / ground_m),
        };
        Some((self.plot(levels, head.look.time, measured, to_db(budget.scnr())), draws))
    }
}
