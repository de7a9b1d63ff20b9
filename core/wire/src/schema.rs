//! Version and fingerprint of the tables.
//!
//! Two builds understand each other when their version **and** the fingerprint of the table are equal. The version is for people,
//! raised by hand; the fingerprint is the CRC-32 of the canonical text below and catches the change that somebody forgot to
//! announce. A test prints every message type in the same notation, from the types themselves, and compares.
//!
//! Notation: `Name{field:type,...}`; `[type;n]` an array; `[type]` a list, its length before it; `?type` an option; an enum's cases in order, parted by `|`, with what
//! each carries. Order is meaning: postcard writes fields in order and an enum's case by its place.

use core::fmt;

use crate::frame::CRC32;

/// Version of both links and both files; raised with every release that changes a table. Between releases the fingerprint tells.
pub const PROTOCOL_VERSION: u16 = 1;

/// Fingerprint of the device link: CRC-32 of [`DEVICE_TABLE`].
pub const SCHEMA_HASH: u32 = CRC32.checksum(DEVICE_TABLE.as_bytes());

/// Fingerprint of the tool link and the files: CRC-32 of [`TOOL_TABLE`].
pub const TOOL_SCHEMA_HASH: u32 = CRC32.checksum(TOOL_TABLE.as_bytes());

/// Fingerprint of the viewer link: CRC-32 of [`VIEWER_TABLE`] and, since models and recordings travel on it, [`TOOL_TABLE`].
pub const VIEWER_SCHEMA_HASH: u32 = {
    let mut digest = CRC32.digest();
    digest.update(VIEWER_TABLE.as_bytes());
    digest.update(TOOL_TABLE.as_bytes());
    digest.finalize()
};

/// The device link in canonical text.
pub const DEVICE_TABLE: &str = "\
FromDevice=Hello(DeviceHello)|Pose(PoseReport)|Fault(DeviceFault)\n\
ToDevice=Hello(HostHello)|SetMode(Mode)|Wrench(WrenchCommand)\n\
DeviceHello{version:u16,schema:u32,name:[u8;12],serial:[u8;12],max_force_un:u32,max_torque_unm:u32,watchdog_ticks:u16}\n\
HostHello{version:u16,schema:u32,period_us:u32}\n\
PoseReport{seq:u32,t_us:u32,position_nm:[i32;3],rotation_q30:[i32;4],buttons:u8,mode:Mode,flags:u8,echo:u32}\n\
WrenchCommand{seq:u32,echo:u32,force_un:[i32;3],torque_unm:[i32;3],hold_us:u32}\n\
DeviceFault{cause:FaultCause,seq:u32,detail:i32}\n\
Mode=Reset|Idle|Force|Brake\n\
FaultCause=Watchdog|OverSpeed|NonFinite|VersionMismatch|Protocol|Hardware\n\
";
/// The tool link and the files in canonical text.
pub const TOOL_TABLE: &str = "\
FromHost=Hello(SessionHello)|Progress(Progress)|Fault(FaultRecord)|Summary(Summary)\n\
SessionHello{version:u16,schema:u32,period_us:u32,device_name:[u8;12],device_serial:[u8;12],max_force_un:u32,max_torque_unm:u32,rt:RtReport,work:?u32}\n\
Progress{tick:u64,regions:u8,force:[f32;3],torque:[f32;3],step_ns:u32,in_time_permille:u16,fault:?HostFault}\n\
FaultRecord{cause:HostFault,tick:u64,after_ticks:u32}\n\
Summary{ticks:u64,in_time:u64,late:u64,lost:u64,rejected:u64,out_of_order:u64,recorder_dropped:u64,peak_force:f32,peak_torque:f32,step_ns:Quantiles,wake_ns:Quantiles,round_trip_ns:Quantiles,rt:RtReport,fault:?HostFault}\n\
Quantiles{p50:u32,p99:u32,p999:u32,p9999:u32,max:u32}\n\
RtReport{fifo:bool,locked:bool,pinned:bool,dma_latency:bool}\n\
HostFault=LinkLost|Stale|Garbage|DeviceRestarted|DeviceFault|DeviceWatchdog|DeviceOverSpeed|DeviceNonFinite|VersionMismatch|NonFinite|Overrun\n\
Record=Header(RecordHeader)|Schema(Chunk)|Scene(Chunk)|Device(SessionHello)|Tuning(Tuning)|Place(Place)|Rest|Tick(TickRecord)|Event(Event)|Fault(FaultRecord)|Lost{count:u64}|End(Summary)\n\
RecordHeader{version:u16,schema:u32,rate_hz:u32,scene_digest:u64,start_unix_s:u32,schema_bytes:u32,scene_bytes:u32}\n\
Chunk{at:u32,bytes:[u8]}\n\
Tuning{tier:Tier,samples:u16,sweeps:u8,friction_static:f32,friction_dynamic:f32,region_distance:f32,max_regions:u8,breakaway:Breakaway,deformation:Deformation,gravity:bool,work:?u32,force_law:ForceLaw,guard:GuardLimits}\n\
Event{tick:u64,what:What}\n\
What=Frozen|Resumed|EmergencyStop|Rearmed|Tared|RecordingBegun|RecordingEnded|Mark\n\
TickRecord{tick:u64,t_us:u64,position:[f32;3],rotation:[f32;4],force:[f32;3],torque:[f32;3],contact_force:[f32;3],contact_torque:[f32;3],regions:u8,depth:f32,radius:f32,stick:f32,tier:Tier,flags:u32,wake_ns:u32,step_ns:u32,round_trip_ns:u32}\n\
BakedScene{object:ObjectShape,fixed_below:f32,young_modulus:f32,poisson_ratio:f32,density:f32,compliance:?Compliance,probe:ProbeParts,mass:f32,inertia:?Inertia,friction_static:f32,friction_dynamic:f32,region_distance:f32,max_regions:u8,tier:Tier,samples:u16,sweeps:u8,deformation:Deformation,coupling:Coupling,breakaway:Breakaway,gravity:bool,work:?u32,force_law:ForceLaw,guard:GuardLimits,paper_length:f32,place:Place}\n\
ObjectShape=HalfSpace|Box{size:[f32;3]}|Sphere{radius:f32}|Ellipsoid{semi_axes:[f32;3]}|Cylinder{radius:f32,height:f32}|Mesh{grid:u8}\n\
Compliance{normal:f32,drag:f32,twist:f32}\n\
Inertia{moments:[f32;3],products:[f32;3]}\n\
ProbeParts{count:u8,parts:[ProbePart;16]}\n\
ProbePart{shape:ProbeShape,position:[f32;3],rotation:[f32;4]}\n\
ProbeShape=Sphere{radius:f32}|Box{size:[f32;3]}|Cylinder{radius:f32,height:f32}|Cone{radius:f32,height:f32}|Capsule{radius:f32,height:f32}|Ellipsoid{semi_axes:[f32;3]}|Mesh{grid:u8}\n\
Tier=Point|Paper|Bristle|Influence|Green\n\
Deformation=None|Local|Full\n\
Coupling=Direct|Virtual(VirtualCoupling)\n\
VirtualCoupling{translational_stiffness:?f32,rotational_stiffness:?f32,translational_damping:?f32,rotational_damping:?f32,max_force:f32,max_torque:f32}\n\
Breakaway=Smooth|Sharp\n\
ForceLaw=Hertz|Cubic{k1:f32,k3:f32}|Table{step:f32,force:[f32;16]}\n\
GuardLimits{max_force:f32,max_torque:f32,max_force_rate:f32,max_torque_rate:f32,ramp_in:f32,passivity:?Passivity}\n\
Passivity{max_damping:f32,max_spin_damping:f32,allowance:f32,reserve:f32,delay_ticks:u8}\n\
Place{p_wd:[f32;3],q_wd:[f32;4]}\n\
";

/// The viewer link in canonical text; what is not here is in [`DEVICE_TABLE`] and [`TOOL_TABLE`].
pub const VIEWER_TABLE: &str = "\
FromViewer=Hello(ViewerHello)|Subscribe(Subscription)|UploadBegin(UploadBegin)|UploadChunk(UploadChunk)|RestBegin(RestBegin)|RestPoints(RestPoints)|Ask(Ask)|Ping(u32)\n\
ToViewer=Refused(Refusal)|Welcome(Welcome)|Device(SessionHello)|Scene(SceneNow)|Upload(UploadState)|Rest(RestState)|Done(u32)|Denied(Denied)|Snapshot(Snapshot)|Surface(SurfaceBlock)|Statistics(Statistics)|Event(Event)|Fault(FaultRecord)|SceneBytes(SceneBytes)|RecordBytes(RecordBytes)|Pong(u32)|End(Summary)\n\
ViewerHello{version:u16,schema:u32,token:[u8;32]}\n\
Refusal{version:u16,schema:u32,why:RefusalCause}\n\
RefusalCause=Version|Token|TooMany|Order|Silent|Idle|Garbage|Stuck\n\
Welcome{version:u16,schema:u32,rate_hz:u32,limits:Limits}\n\
Limits{viewers:u8,model_bytes:u32,rest_points:u32,idle_ms:u32}\n\
Subscription{every:u32,surface:u32,statistics_ms:u32}\n\
UploadBegin{digest:u64,length:u32}\n\
UploadChunk{digest:u64,offset:u32,bytes:[u8]}\n\
UploadState{digest:u64,have:u32,of:u32,why:?Denial}\n\
RestBegin{count:u32}\n\
RestPoints{offset:u32,points:[[f32;3]]}\n\
RestState{have:u32,of:u32,why:?Denial}\n\
Ask{number:u32,what:Wish}\n\
Wish=Activate(u64)|Tune(Tuning)|Freeze(bool)|Tare|EStop|Rearm|Record(bool)|Download|Budget(WorkBudget)\n\
WorkBudget=Scene|Auto|Off|Work(u32)\n\
Denied{number:u32,why:Denial,words:[u8]}\n\
Denial=NoModel|Digest|Scene|Value|InContact|NoSession|Stopped|NotStopped|Frozen|Busy|TooLarge|NoRoom|OutOfOrder|Recording|NotRecording\n\
SceneNow{digest:u64,length:u32}\n\
SceneBytes{digest:u64,offset:u32,of:u32,bytes:[u8]}\n\
RecordBytes{offset:u64,bytes:[u8]}\n\
Snapshot{tick:u64,t_us:u64,position:[f32;3],rotation:[f32;4],contact_force:[f32;3],contact_torque:[f32;3],sent_force:[f32;3],sent_torque:[f32;3],patches:[PatchLook],depth:f32,tier:Tier,flags:u32,wake_ns:u32,step_ns:u32,round_trip_ns:u32,in_time_permille:u16,mode:Mode,output:OutputState,fault:?HostFault}\n\
PatchLook{region:u8,centre:[f32;3],normal:[f32;3],radius:f32,stick_radius:f32,force:[f32;3],torque:[f32;3],depth:f32}\n\
OutputState=Closed|Open|Frozen|Stopped\n\
SurfaceBlock{tick:u64,of:u32,offset:u32,step:f32,moved:[[i16;3]]}\n\
Statistics{session:Summary,viewers:u8,sent:u64,dropped:u64,surfaces:u64,passes:u64,points:u64,behind:u64,missed:u64,rejected:u32}\n\
at most: 4096 bytes, 256 points, 160 words, 16 patches\n\
";

/// Host and device, or tool and host, were built from different tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VersionMismatch {
    /// Version of this side.
    pub our_version: u16,
    /// Version of the other side.
    pub their_version: u16,
    /// Fingerprint of this side.
    pub our_schema: u32,
    /// Fingerprint of the other side.
    pub their_schema: u32,
}

impl fmt::Display for VersionMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the other side speaks version {} (table {:08x}), this side version {} (table {:08x})",
            self.their_version, self.their_schema, self.our_version, self.our_schema
        )
    }
}

impl core::error::Error for VersionMismatch {}

/// Compares what the other end of the device link said in its hello.
///
/// # Errors
/// [`VersionMismatch`] with both versions and both fingerprints.
pub const fn check_device_version(version: u16, schema: u32) -> Result<(), VersionMismatch> {
    check(version, schema, SCHEMA_HASH)
}

/// Compares what the other end of the tool link, or a file, says.
///
/// # Errors
/// [`VersionMismatch`] with both versions and both fingerprints.
pub const fn check_tool_version(version: u16, schema: u32) -> Result<(), VersionMismatch> {
    check(version, schema, TOOL_SCHEMA_HASH)
}

/// Compares what a viewer said in its hello, or a host in its welcome.
///
/// # Errors
/// [`VersionMismatch`] with both versions and both fingerprints.
pub const fn check_viewer_version(version: u16, schema: u32) -> Result<(), VersionMismatch> {
    check(version, schema, VIEWER_SCHEMA_HASH)
}

const fn check(version: u16, schema: u32, ours: u32) -> Result<(), VersionMismatch> {
    if version == PROTOCOL_VERSION && schema == ours {
        return Ok(());
    }
    Err(VersionMismatch { our_version: PROTOCOL_VERSION, their_version: version, our_schema: ours, their_schema: schema })
}
