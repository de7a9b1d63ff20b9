//! A body as the contents of a kept file: little endian, every list behind its length.

use glam::{DMat3, DVec3, Vec3};
use haptor_contact::{Invalid, SurfaceSample};

use super::{Body, Part};
use crate::bake::{Baked, DistanceError};
use crate::convex::Hollow;
use crate::kept::{Keep, KeptError, Kind};
use crate::mesh::Mesh;

impl Keep for Body {
    // the most bytes: sixteen parts of 128 x 128 x 128 nodes fit twice, and so does a mesh of a million triangles
    const KIND: Kind = Kind { magic: *b"haptmsh\0", format: 1, max_bytes: 256 << 20, name: "mesh" };

    fn to_contents(&self) -> Vec<u8> {
        let mut out = Writer(Vec::new());
        let columns = self.inertia.to_cols_array();
        out.wide(&columns);
        out.wide(&self.size.to_array());
        out.wide(&[self.hollow.depth, self.hollow.share]);
        out.count(self.mended.len());
        self.mended.iter().for_each(|line| out.bytes(line.as_bytes()));
        out.count(self.parts.len());
        self.parts.iter().for_each(|part| out.part(part));
        out.0
    }

    fn from_contents(contents: &[u8]) -> Result<Self, KeptError> {
        let mut from = Reader { rest: contents, total: contents.len() };
        let inertia = DMat3::from_cols_array(&from.wide()?);
        let size = DVec3::from_array(from.wide()?);
        let [depth, share] = from.wide()?;
        let mended = from.list(|from| Ok(String::from_utf8_lossy(from.bytes()?).into_owned()))?;
        let parts = from.list(Reader::part)?;
        if !from.rest.is_empty() {
            return Err(from.wrong());
        }
        Ok(Self { parts, inertia, size, hollow: Hollow { depth, share }, mended })
    }
}

struct Writer(Vec<u8>);

impl Writer {
    fn count(&mut self, count: usize) {
        self.0.extend((count as u64).to_le_bytes());
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.count(bytes.len());
        self.0.extend(bytes);
    }

    fn wide(&mut self, numbers: &[f64]) {
        self.0.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }

    fn narrow(&mut self, numbers: &[f32]) {
        self.0.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }

    fn part(&mut self, part: &Part) {
        self.wide(&part.position.to_array());
        self.count(part.mesh.vertices.len());
        part.mesh.vertices.iter().for_each(|vertex| self.wide(&vertex.to_array()));
        self.count(part.mesh.triangles.len());
        self.0.extend(part.mesh.triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes()));
        self.baked(&part.baked);
    }

    fn baked(&mut self, baked: &Baked) {
        let Baked { origin, spacing, counts, coefficients, samples, low, high, volume, reach, error, longest_edge } = baked;
        counts.iter().for_each(|&count| self.count(count));
        [origin, low, high].iter().for_each(|v| self.narrow(&v.to_array()));
        self.narrow(&[*spacing, *volume, *reach]);
        self.wide(&[error.max, error.rms, *longest_edge]);
        self.count(coefficients.len());
        self.narrow(coefficients);
        self.count(samples.len());
        for sample in samples {
            self.narrow(&sample.position.to_array());
            self.narrow(&sample.normal.to_array());
            self.narrow(&[sample.area]);
        }
    }
}

struct Reader<'a> {
    rest: &'a [u8],
    total: usize,
}

impl<'a> Reader<'a> {
    fn wrong(&self) -> KeptError {
        KeptError::Length { found: self.total, expected: self.total - self.rest.len() }
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], KeptError> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or_else(|| self.wrong())?;
        self.rest = rest;
        Ok(taken)
    }

    fn fixed<const N: usize>(&mut self) -> Result<[u8; N], KeptError> {
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        Ok(bytes)
    }

    fn count(&mut self) -> Result<usize, KeptError> {
        usize::try_from(u64::from_le_bytes(self.fixed()?)).map_err(|_| self.wrong())
    }

    fn bytes(&mut self) -> Result<&'a [u8], KeptError> {
        let count = self.count()?;
        self.take(count)
    }

    fn wide<const N: usize>(&mut self) -> Result<[f64; N], KeptError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f64::from_le_bytes(self.fixed()?);
        }
        Ok(numbers)
    }

    fn narrow<const N: usize>(&mut self) -> Result<[f32; N], KeptError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f32::from_le_bytes(self.fixed()?);
        }
        Ok(numbers)
    }

    fn corner(&mut self) -> Result<u32, KeptError> {
        self.fixed().map(u32::from_le_bytes)
    }

    /// A list of things, none of which takes no bytes, so that no length can ask for more than the file has.
    fn list<T>(&mut self, one: impl Fn(&mut Self) -> Result<T, KeptError>) -> Result<Vec<T>, KeptError> {
        let count = self.count()?;
        if count > self.rest.len() {
            return Err(self.wrong());
        }
        (0..count).map(|_| one(self)).collect()
    }

    fn vector(&mut self) -> Result<Vec3, KeptError> {
        self.narrow().map(Vec3::from_array)
    }

    fn part(&mut self) -> Result<Part, KeptError> {
        let position = DVec3::from_array(self.wide()?);
        let vertices = self.list(|from| from.wide().map(DVec3::from_array))?;
        let triangles = self.list(|from| Ok([from.corner()?, from.corner()?, from.corner()?]))?;
        if triangles.iter().flatten().any(|&corner| corner as usize >= vertices.len()) {
            return Err(self.wrong());
        }
        let baked = self.baked()?;
        Ok(Part { mesh: Mesh { vertices, triangles }, baked, position })
    }

    fn baked(&mut self) -> Result<Baked, KeptError> {
        let counts = [self.count()?, self.count()?, self.count()?];
        let (origin, low, high) = (self.vector()?, self.vector()?, self.vector()?);
        let [spacing, volume, reach] = self.narrow()?;
        let [max, rms, longest_edge] = self.wide()?;
        let coefficients = self.list(|from| from.narrow().map(|[number]| number))?;
        let samples = self.list(|from| {
            Ok(SurfaceSample { position: from.vector()?, normal: from.vector()?, area: from.narrow().map(|[area]| area)? })
        })?;
        let error = DistanceError { max, rms };
        let baked = Baked { origin, spacing, counts, coefficients, samples, low, high, volume, reach, error, longest_edge };
        baked.shape().map_err(|invalid: Invalid| KeptError::from(invalid))?;
        Ok(baked)
    }
}
