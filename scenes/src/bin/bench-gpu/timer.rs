//! How long commands take on the device.

use std::error::Error;
use std::time::{Duration, Instant};

use bdtree_measure::stats::median;

/// An idle GPU runs at a fraction of its clock rate (an H200's multiprocessors at 345 MHz).
const WARM_UP: Duration = Duration::from_millis(500);

/// Measures by timestamps of the device, or by the clock where it has none.
pub(crate) struct Timer<'d> {
    device: &'d wgpu::Device,
    queue: &'d wgpu::Queue,
    stamps: Option<Stamps>,
    /// Submissions, of which the median counts, after [`WARM_UP`].
    pub(crate) rounds: usize,
    /// Executions in each.
    repeats: u32,
}

struct Stamps {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    read: wgpu::Buffer,
}

impl<'d> Timer<'d> {
    pub(crate) fn new(
        device: &'d wgpu::Device,
        queue: &'d wgpu::Queue,
        rounds: usize,
        repeats: u32,
    ) -> Self {
        use wgpu::Features as F;
        let needed = F::TIMESTAMP_QUERY | F::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: 16,
                usage,
                mapped_at_creation: false,
            })
        };
        let stamps = device.features().contains(needed).then(|| Stamps {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            read: buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
        });
        Self {
            device,
            queue,
            stamps,
            rounds,
            repeats,
        }
    }

    /// What measures.
    pub(crate) fn method(&self) -> &'static str {
        match self.stamps {
            Some(_) => "timestamps of the device",
            None => "the clock, around submissions that are waited for",
        }
    }

    /// Median seconds of one execution of what `record` records.
    pub(crate) fn seconds(
        &self,
        record: impl Fn(&mut wgpu::CommandEncoder) -> Result<(), Box<dyn Error>>,
    ) -> Result<f64, Box<dyn Error>> {
        let mut all = Vec::new();
        let (began, mut warm) = (Instant::now(), false);
        while all.len() < self.rounds {
            let mut encoder = self.device.create_command_encoder(&Default::default());
            if let Some(stamps) = &self.stamps {
                encoder.write_timestamp(&stamps.set, 0);
            }
            for _ in 0..self.repeats {
                record(&mut encoder)?;
            }
            if let Some(stamps) = &self.stamps {
                encoder.write_timestamp(&stamps.set, 1);
                encoder.resolve_query_set(&stamps.set, 0..2, &stamps.resolved, 0);
                encoder.copy_buffer_to_buffer(&stamps.resolved, 0, &stamps.read, 0, 16);
            }
            let commands = encoder.finish();
            let start = Instant::now();
            self.queue.submit([commands]);
            self.device.poll(wgpu::PollType::wait_indefinitely())?;
            let wall = start.elapsed().as_secs_f64();
            let seconds = match &self.stamps {
                Some(stamps) => self.read(stamps)?,
                None => wall,
            };
            if warm {
                all.push(seconds / f64::from(self.repeats));
            }
            warm = warm || began.elapsed() >= WARM_UP;
        }
        Ok(median(&all))
    }

    fn read(&self, stamps: &Stamps) -> Result<f64, Box<dyn Error>> {
        stamps.read.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        let view = stamps.read.slice(..).get_mapped_range()?;
        let ticks: Vec<u64> = (view.as_chunks().0.iter().copied())
            .map(u64::from_le_bytes)
            .collect();
        drop(view);
        stamps.read.unmap();
        let ticks = ticks[1].saturating_sub(ticks[0]) as f64;
        Ok(ticks * f64::from(self.queue.get_timestamp_period()) * 1e-9)
    }
}
