//! The graphics driver: OpenGL 3.3 or OpenGL ES 3, the one file of this crate with `unsafe`.
//!
//! [`Renderer`] keeps a picture's batches in buffers and draws them as the rasteriser does; [`Screenless`] is a driver without a window or a
//! display, through EGL. A context must be current on the calling thread: egui's paint callback and [`Screenless`] see to it.
#![expect(unsafe_code, reason = "calls into the graphics driver")]

use std::ffi::CStr;
use std::sync::Arc;

use eframe::glow::{self, HasContext as _};
use glam::{DVec3, Mat3, Mat4, Vec3};
use glutin::api::egl::{self, context::PossiblyCurrentContext, device::Device, display::Display};
use glutin::config::{ConfigSurfaceTypes, ConfigTemplateBuilder};
use glutin::context::{ContextApi, ContextAttributesBuilder, Version};
use glutin::display::GlDisplay as _;

use crate::camera::Orbit;
use crate::picture::{Batch, LAYERS, Paint, Picture};

/// Numbers of the vertex attributes.
const POSITION: u32 = 0;
const NORMAL: u32 = 1;
const COLOUR: u32 = 2;

const VERTEX: &str = "
in vec3 position;
in vec3 normal;
in vec4 colour;
uniform mat4 view;
uniform mat4 frustum;
uniform float lift;
out vec3 seen;
out vec3 turned;
out vec4 tint;
void main() {
    vec4 at = view * vec4(position, 1.0);
    seen = at.xyz;
    turned = mat3(view) * normal;
    tint = colour;
    gl_Position = frustum * at;
    vec4 lifted = frustum * vec4(at.xyz * (1.0 - lift / length(at.xyz)), 1.0);
    gl_Position.z = lifted.z / lifted.w * gl_Position.w;
}
";

/// The light of the rasteriser, in its gamma of 2.
const FRAGMENT: &str = "
in vec3 seen;
in vec3 turned;
in vec4 tint;
uniform vec3 light;
uniform float opacity;
uniform float lit;
out vec4 shown;
void main() {
    vec3 towards = normalize(-seen);
    vec3 n = normalize(turned);
    n = dot(n, towards) < 0.0 ? -n : n;
    float diffuse = 0.35 + 0.55 * max(dot(n, light), 0.0) + 0.18 * max(dot(n, towards), 0.0);
    float gloss = pow(max(dot(n, normalize(light + towards)), 0.0), 48.0);
    vec3 linear = tint.rgb * tint.rgb;
    linear = mix(linear, linear * diffuse + vec3(0.08 * gloss), lit);
    float away = 1.0 - abs(dot(n, towards));
    float rim = lit > 0.5 && opacity < 1.0 ? 1.0 + away * away : 1.0;
    float cover = min(opacity * tint.a * rim, 1.0);
    shown = vec4(sqrt(clamp(linear, 0.0, 1.0)) * cover, cover);
}
";

/// From a surface to the light, in world, as in the rasteriser.
const LIGHT: Vec3 = Vec3::new(-0.5, -0.25, 0.8);

/// A batch as the driver keeps it.
#[derive(Clone, Copy, Debug)]
struct Stored {
    array: glow::VertexArray,
    vertices: [glow::Buffer; 3],
    triangles: glow::Buffer,
    /// Versions stored; `None` = nothing yet.
    versions: [Option<u64>; 2],
}

#[derive(Debug)]
struct Uniforms {
    view: Option<glow::UniformLocation>,
    frustum: Option<glow::UniformLocation>,
    lift: Option<glow::UniformLocation>,
    light: Option<glow::UniformLocation>,
    opacity: Option<glow::UniformLocation>,
    lit: Option<glow::UniformLocation>,
}

/// A picture in the driver's memory.
#[derive(Debug)]
pub struct Renderer {
    program: glow::Program,
    uniforms: Uniforms,
    stored: [Stored; LAYERS],
}

impl Renderer {
    /// Compiles the shaders and makes the buffers.
    ///
    /// # Errors
    /// What the driver says when it cannot.
    pub fn new(gl: &glow::Context) -> Result<Self, String> {
        // SAFETY: the context is current; every name passed was made by it two lines before
        unsafe {
            let program = link(gl)?;
            let at = |name| gl.get_uniform_location(program, name);
            let uniforms = Uniforms {
                view: at("view"),
                frustum: at("frustum"),
                lift: at("lift"),
                light: at("light"),
                opacity: at("opacity"),
                lit: at("lit"),
            };
            let mut stored = Vec::with_capacity(LAYERS);
            for _ in 0..LAYERS {
                let vertices = [gl.create_buffer()?, gl.create_buffer()?, gl.create_buffer()?];
                let array = gl.create_vertex_array()?;
                stored.push(Stored { array, vertices, triangles: gl.create_buffer()?, versions: [None; 2] });
            }
            let stored = stored.try_into().map_err(|_| "wrong number of layers".to_owned())?;
            Ok(Self { program, uniforms, stored })
        }
    }

    /// The batches belong to another stage from here on.
    pub fn forget(&mut self) {
        self.stored.iter_mut().for_each(|stored| stored.versions = [None; 2]);
    }

    /// Draws a picture into the viewport that is set, over what is there; only what changed since the last call is sent to the driver.
    pub fn draw(&mut self, gl: &glow::Context, picture: &Picture, orbit: &Orbit, aspect: f64) {
        let [view, frustum] = orbit.matrices(aspect);
        let light = Mat3::from_mat4(view) * LIGHT.normalize();
        // SAFETY: the context is current; program and buffers are its own; the state changed here is put back or set anew by egui
        unsafe {
            gl.enable(glow::DEPTH_TEST);
            gl.depth_mask(true);
            gl.clear_depth_f32(1.0);
            gl.clear(glow::DEPTH_BUFFER_BIT);
            gl.blend_func(glow::ONE, glow::ONE_MINUS_SRC_ALPHA);
            gl.use_program(Some(self.program));
            gl.uniform_matrix_4_f32_slice(self.uniforms.frustum.as_ref(), false, &frustum.to_cols_array());
            gl.uniform_3_f32(self.uniforms.light.as_ref(), light.x, light.y, light.z);
        }
        for (batch, stored) in picture.batches.iter().zip(&mut self.stored) {
            if !batch.is_empty() {
                store(gl, batch, stored);
                draw_batch(gl, &self.uniforms, batch, stored, view, orbit.back());
            }
        }
        // SAFETY: as above
        unsafe {
            gl.bind_vertex_array(None);
            gl.disable(glow::DEPTH_TEST);
            gl.disable(glow::CULL_FACE);
            gl.depth_mask(true);
            gl.depth_func(glow::LESS);
            gl.use_program(None);
        }
    }

    /// Gives everything back to the driver.
    pub fn destroy(&self, gl: &glow::Context) {
        // SAFETY: the context is current, the names are its own and not used again
        unsafe {
            gl.delete_program(self.program);
            for stored in &self.stored {
                gl.delete_vertex_array(stored.array);
                stored.vertices.iter().chain([&stored.triangles]).for_each(|&buffer| gl.delete_buffer(buffer));
            }
        }
    }
}

/// Shaders to a program.
///
/// # Safety
/// The context is current.
unsafe fn link(gl: &glow::Context) -> Result<glow::Program, String> {
    let header = if gl.version().is_embedded { "#version 300 es\nprecision highp float;\n" } else { "#version 330 core\n" };
    // SAFETY: the context is current; names are used as what they were made
    unsafe {
        let program = gl.create_program()?;
        for (number, name) in [(POSITION, "position"), (NORMAL, "normal"), (COLOUR, "colour")] {
            gl.bind_attrib_location(program, number, name);
        }
        for (kind, source) in [(glow::VERTEX_SHADER, VERTEX), (glow::FRAGMENT_SHADER, FRAGMENT)] {
            let shader = gl.create_shader(kind)?;
            gl.shader_source(shader, &format!("{header}{source}"));
            gl.compile_shader(shader);
            if !gl.get_shader_compile_status(shader) {
                return Err(gl.get_shader_info_log(shader));
            }
            gl.attach_shader(program, shader);
            // it lives on as long as the program
            gl.delete_shader(shader);
        }
        gl.link_program(program);
        if gl.get_program_link_status(program) { Ok(program) } else { Err(gl.get_program_info_log(program)) }
    }
}

/// Sends what changed.
fn store(gl: &glow::Context, batch: &Batch, stored: &mut Stored) {
    let [vertices, triangles] = [batch.vertices_version, batch.triangles_version].map(Some);
    // SAFETY: the context is current; the driver copies the bytes before each call returns
    unsafe {
        gl.bind_vertex_array(Some(stored.array));
        if stored.versions[0] != vertices {
            let [positions, normals, colours] = stored.vertices;
            upload(gl, positions, POSITION, &batch.positions, 3, glow::FLOAT);
            upload(gl, normals, NORMAL, &batch.normals, 3, glow::FLOAT);
            upload(gl, colours, COLOUR, &batch.colours, 4, glow::UNSIGNED_BYTE);
        }
        if stored.versions[1] != triangles {
            gl.bind_buffer(glow::ELEMENT_ARRAY_BUFFER, Some(stored.triangles));
            gl.buffer_data_u8_slice(glow::ELEMENT_ARRAY_BUFFER, bytes(&batch.triangles), glow::STATIC_DRAW);
        }
    }
    stored.versions = [vertices, triangles];
}

/// Values of a vertex attribute, `parts` numbers each.
///
/// # Safety
/// The context is current, a vertex array is bound, and `T` holds `parts` numbers of `kind` and nothing else.
unsafe fn upload<T: Copy>(gl: &glow::Context, buffer: glow::Buffer, number: u32, values: &[T], parts: i32, kind: u32) {
    // SAFETY: as demanded of the caller
    unsafe {
        gl.bind_buffer(glow::ARRAY_BUFFER, Some(buffer));
        gl.buffer_data_u8_slice(glow::ARRAY_BUFFER, bytes(values), glow::DYNAMIC_DRAW);
        gl.enable_vertex_attrib_array(number);
        gl.vertex_attrib_pointer_f32(number, parts, kind, kind == glow::UNSIGNED_BYTE, 0, 0);
    }
}

/// The bytes of numbers.
///
/// # Safety
/// `T` is made of numbers without gaps between them.
unsafe fn bytes<T: Copy>(values: &[T]) -> &[u8] {
    // SAFETY: bytes need no alignment, every byte of a number may be read, the borrow keeps them alive
    unsafe { std::slice::from_raw_parts(values.as_ptr().cast(), size_of_val(values)) }
}

/// Draws a batch that is stored; one that is seen behind others first where it is behind.
fn draw_batch(gl: &glow::Context, uniforms: &Uniforms, batch: &Batch, stored: &Stored, view: Mat4, towards: DVec3) {
    let paint = batch.paint;
    let place = Mat4::from_rotation_translation(batch.place.rotation.as_quat(), batch.place.position.as_vec3());
    let opacity = paint.opacity_from(towards.as_vec3());
    // SAFETY: the context is current, the program in use, the array holds the batch's triangles
    unsafe {
        gl.bind_vertex_array(Some(stored.array));
        gl.uniform_matrix_4_f32_slice(uniforms.view.as_ref(), false, &(view * place).to_cols_array());
        gl.uniform_1_f32(uniforms.lift.as_ref(), paint.lift);
        gl.uniform_1_f32(uniforms.lit.as_ref(), f32::from(u8::from(paint.lit)));
        if paint.one_sided {
            gl.enable(glow::CULL_FACE);
        } else {
            gl.disable(glow::CULL_FACE);
        }
        if paint.behind > 0.0 {
            draw_pass(gl, uniforms, batch, glow::GREATER, Paint { hides: false, opacity: paint.behind * opacity, ..paint });
        }
        draw_pass(gl, uniforms, batch, glow::LESS, Paint { opacity, ..paint });
    }
}

/// # Safety
/// As in [`draw_batch`], with everything set but depth and opacity.
unsafe fn draw_pass(gl: &glow::Context, uniforms: &Uniforms, batch: &Batch, depth: u32, paint: Paint) {
    // SAFETY: as demanded of the caller
    unsafe {
        gl.depth_func(depth);
        gl.depth_mask(paint.hides);
        gl.uniform_1_f32(uniforms.opacity.as_ref(), paint.opacity);
        gl.draw_elements(glow::TRIANGLES, 3 * batch.triangles.len() as i32, glow::UNSIGNED_INT, 0);
    }
}

/// Samples a pixel of a picture without a window.
const SAMPLES: i32 = 4;

/// A driver without a window: a picture in its memory that can be read back.
pub struct Screenless {
    gl: Arc<glow::Context>,
    size: [u32; 2],
    /// Drawn into, several samples a pixel; and read from.
    targets: [glow::Framebuffer; 2],
    /// Keeps the context current while this lives.
    _context: PossiblyCurrentContext,
}

impl Screenless {
    /// Opens the first device that can draw.
    ///
    /// # Errors
    /// When there is no EGL or no device, in words that name the packages to install.
    pub fn open(size: [u32; 2]) -> Result<Self, String> {
        let missing = |what: String| {
            format!("no OpenGL without a display: {what}; on Debian and Ubuntu: apt-get install libegl1 libgl1-mesa-dri")
        };
        let devices = Device::query_devices().map_err(|error| missing(error.to_string()))?;
        // the first device may be one that we have no right to use
        let context = devices.filter_map(|device| context(&device).ok()).next();
        let (display, context) = context.ok_or_else(|| missing("no device of EGL can draw".to_owned()))?;
        // SAFETY: the display outlives the loading; EGL gives functions of the context that is current
        let gl = unsafe { glow::Context::from_loader_function_cstr(|name: &CStr| display.get_proc_address(name)) };
        let targets = [target(&gl, size, SAMPLES)?, target(&gl, size, 0)?];
        Ok(Self { gl: Arc::new(gl), size, targets, _context: context })
    }

    /// The driver.
    pub fn gl(&self) -> &Arc<glow::Context> {
        &self.gl
    }

    /// What is drawn from here on goes into the picture, which is cleared.
    pub fn begin(&self) {
        // SAFETY: the context is current, the target its own
        unsafe {
            self.gl.bind_framebuffer(glow::FRAMEBUFFER, Some(self.targets[0]));
            self.gl.disable(glow::SCISSOR_TEST);
            self.gl.clear_color(0.0, 0.0, 0.0, 1.0);
            self.gl.clear(glow::COLOR_BUFFER_BIT | glow::DEPTH_BUFFER_BIT);
        }
    }

    /// The picture: rows from the top, red, green, blue.
    pub fn read(&self) -> Vec<u8> {
        let [width, height] = self.size.map(|side| side as i32);
        let mut rgba = vec![0; 4 * self.size[0] as usize * self.size[1] as usize];
        // SAFETY: the context is current, the targets its own; the driver fills exactly the bytes of the slice
        unsafe {
            self.gl.disable(glow::SCISSOR_TEST);
            self.gl.bind_framebuffer(glow::READ_FRAMEBUFFER, Some(self.targets[0]));
            self.gl.bind_framebuffer(glow::DRAW_FRAMEBUFFER, Some(self.targets[1]));
            self.gl.blit_framebuffer(0, 0, width, height, 0, 0, width, height, glow::COLOR_BUFFER_BIT, glow::NEAREST);
            self.gl.bind_framebuffer(glow::FRAMEBUFFER, Some(self.targets[1]));
            let pixels = glow::PixelPackData::Slice(Some(&mut rgba));
            self.gl.read_pixels(0, 0, width, height, glow::RGBA, glow::UNSIGNED_BYTE, pixels);
        }
        let rows = rgba.chunks_exact(4 * self.size[0] as usize).rev();
        rows.flat_map(|row| row.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])).collect()
    }
}

/// A place to draw into, colour and depth; `samples` a pixel, 0 = one that can be read.
fn target(gl: &glow::Context, size: [u32; 2], samples: i32) -> Result<glow::Framebuffer, String> {
    let [width, height] = size.map(|side| side as i32);
    // SAFETY: the context is current; names are used as what they were made
    unsafe {
        let target = gl.create_framebuffer()?;
        gl.bind_framebuffer(glow::FRAMEBUFFER, Some(target));
        for (kind, place) in [(glow::RGBA8, glow::COLOR_ATTACHMENT0), (glow::DEPTH_COMPONENT24, glow::DEPTH_ATTACHMENT)] {
            let buffer = gl.create_renderbuffer()?;
            gl.bind_renderbuffer(glow::RENDERBUFFER, Some(buffer));
            gl.renderbuffer_storage_multisample(glow::RENDERBUFFER, samples, kind, width, height);
            gl.framebuffer_renderbuffer(glow::FRAMEBUFFER, place, glow::RENDERBUFFER, Some(buffer));
        }
        let status = gl.check_framebuffer_status(glow::FRAMEBUFFER);
        if status == glow::FRAMEBUFFER_COMPLETE { Ok(target) } else { Err(format!("framebuffer status {status:#x}")) }
    }
}

/// A current context on a device.
fn context(device: &Device) -> Result<(Display, PossiblyCurrentContext), glutin::error::Error> {
    let template = ConfigTemplateBuilder::new().with_surface_type(ConfigSurfaceTypes::empty()).build();
    let attributes = ContextAttributesBuilder::new().with_context_api(ContextApi::OpenGl(Some(Version::new(3, 3)))).build(None);
    // SAFETY: no window and no native display is handed over; display and configuration belong to each other
    unsafe {
        let display = Display::with_device(device, None)?;
        let config: egl::config::Config = display.find_configs(template)?.next().ok_or(glutin::error::ErrorKind::BadConfig)?;
        let context = display.create_context(&config, &attributes)?.make_current_surfaceless()?;
        Ok((display, context))
    }
}
