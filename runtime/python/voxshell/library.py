# SPDX-License-Identifier: MIT
"""The runtime's shared library: found, loaded, and its errors raised.

It is $VOXSHELL_LIBRARY if that is set, else the one that the wheel carries beside this file; the library of the devices lies beside it. PROTOTYPES are the
declarations of the headers that are called here, word for word as far as a C compiler cares: a test compiles them against
runtime/include, and the layout of every Struct too, so nothing here can drift from the C side unseen.
"""
import ctypes
import os
import re

PROTOTYPES = """
uint32_t vxs_version(void);
const char *vxs_result_name(vxs_result result);
const char *vxs_result_text(vxs_result result);
void vxs_asset_config_default(vxs_asset_config *config);
vxs_result vxs_asset_open(const char *path, const vxs_asset_config *config, vxs_asset *out, vxs_asset_issue *issue);
vxs_result vxs_asset_from_memory(const void *data, size_t size, const vxs_asset_config *config, vxs_asset *out,
                                 vxs_asset_issue *issue);
void vxs_asset_close(vxs_asset *asset);
vxs_result vxs_voxmap_open(const vxs_asset *asset, vxs_voxmap *out);
vxs_result vxs_pointshell_open(const vxs_asset *asset, vxs_pointshell *out);
vxs_result vxs_plan_open(const vxs_asset *asset, vxs_plan *out);
size_t vxs_plan_memory(const vxs_plan *plan);
vxs_result vxs_plan_load(const vxs_plan *plan, const vxs_asset *assets, void *memory, size_t size,
                         vxs_servo_config *config, vxs_plan_issue *issue);
const vxs_effect_constant *vxs_effect_constants(uint32_t kind, uint32_t *count);
uint32_t vxs_effect_kind_named(const char *name);
void vxs_contact_config_default(vxs_contact_config *config);
vxs_result vxs_contact_config_check(const vxs_contact_config *config);
size_t vxs_contact_memory(const vxs_pointshell *shell, uint32_t statics);
vxs_result vxs_contact_init(void *memory, size_t size, const vxs_pointshell *shell, uint32_t statics, vxs_contact **out);
int vxs_contact_has_field(const vxs_voxmap *map, uint32_t field);
double vxs_contact_point_cost(vxs_contact *contact);
uint32_t vxs_contact_evaluate(vxs_contact *contact, const vxs_contact_static *statics, uint32_t count,
                              const vxs_pose *pose, const vxs_contact_config *config, vxs_contact_result *result);
void vxs_servo_config_default(vxs_servo_config *config);
size_t vxs_servo_memory(const vxs_servo_config *config);
vxs_result vxs_servo_init(void *memory, size_t size, const vxs_servo_config *config, vxs_servo **out);
uint32_t vxs_servo_tick(vxs_servo *servo, const vxs_device_state *state, vxs_device_command *command,
                        vxs_servo_trace *trace);
void vxs_servo_clear(vxs_servo *servo);
vxs_result vxs_device_arm(vxs_device *device);
vxs_result vxs_device_disarm(vxs_device *device);
void vxs_device_close(vxs_device *device);
void vxs_device_exchange(vxs_device *device, const vxs_device_command *command, vxs_device_state *state,
                         vxs_device_report *report);
const vxs_simulated_profile *vxs_simulated_profile_named(const char *name);
const vxs_simulated_profile *vxs_simulated_profile_at(uint32_t index);
const vxs_simulated_arm *vxs_simulated_arm_named(const char *name);
void vxs_simulated_config_default(vxs_simulated_config *config, const vxs_simulated_profile *profile);
size_t vxs_simulated_memory(void);
vxs_result vxs_simulated_open(void *memory, size_t size, const vxs_simulated_config *config, vxs_device **out);
void vxs_simulated_hand(vxs_device *device, const double position[3], const double *orientation);
size_t vxs_trace_memory(uint32_t rows);
vxs_result vxs_trace_init(void *memory, size_t size, uint32_t rows, vxs_trace **out);
size_t vxs_trace_drain(vxs_trace *trace, vxs_servo_trace *rows, size_t max);
uint64_t vxs_trace_dropped(const vxs_trace *trace);
void vxs_servo_thread_config_default(vxs_servo_thread_config *config);
size_t vxs_servo_thread_memory(void);
vxs_result vxs_servo_thread_start(void *memory, size_t size, const vxs_servo_thread_config *config,
                                  vxs_servo_thread **out);
void vxs_servo_thread_get(const vxs_servo_thread *thread, vxs_servo_thread_status *status);
void vxs_servo_thread_stop(vxs_servo_thread *thread);
"""

# Of the library of the devices.
DEVICES = """
void vxs_replay_config_default(vxs_replay_config *config);
size_t vxs_replay_memory(void);
vxs_result vxs_replay_open(void *memory, size_t size, const vxs_replay_config *config,
                           vxs_device **out);
vxs_result vxs_replay_parse(const void *bytes, size_t size, vxs_replay_row *rows, size_t most,
                            size_t *count, size_t *line);
const vxs_hardware_kind *vxs_hardware_kind_at(uint32_t index);
const vxs_hardware_kind *vxs_hardware_kind_named(const char *name);
void vxs_hardware_config_default(vxs_hardware_config *config);
size_t vxs_hardware_memory(void);
vxs_result vxs_hardware_open(void *memory, size_t size, const vxs_hardware_kind *kind,
                             const vxs_hardware_config *config, vxs_device **out);
"""

VALUES = {"void": None, "int": ctypes.c_int, "vxs_result": ctypes.c_int, "uint32_t": ctypes.c_uint32, "uint64_t": ctypes.c_uint64,
          "size_t": ctypes.c_size_t, "double": ctypes.c_double}


class Error(Exception):
    """What the runtime refused, in its own words.

    result    its name: "VXS_CORRUPT" (voxshell/result.h has all of them)
    rule      of a file: the rule of formats/*.md that it breaks first, "M305"; else None
    section   and where: the section's name, "BRIK",
    offset    and the byte from the file's start
    """

    def __init__(self, code, what="", rule=None, section=None, offset=None, detail=""):
        self.result = load().vxs_result_name(code).decode()
        self.rule, self.section, self.offset = rule, section, offset
        text = load().vxs_result_text(code).decode()
        where = f"rule {rule}, section {section}, byte {offset}: " if rule else ""
        super().__init__((f"{what}: " if what else "") + text + (f": {where}{detail}" if where or detail else ""))


class Struct(ctypes.Structure):
    """A C struct of the same fields in the same order. C_NAME is its name there."""

    C_NAME = ""

    @classmethod
    def default(cls):
        """As its _default() function fills it, which says how large the library thinks it is, too."""
        made = cls()
        getattr(load(), f"{cls.C_NAME}_default")(ctypes.byref(made))
        if made.struct_size != ctypes.sizeof(cls):
            raise ImportError(f"{load()._name}: {cls.C_NAME} has {made.struct_size} bytes there and {ctypes.sizeof(cls)} here: "
                              "take the library that this package was made with")
        return made


class Memory:
    """Bytes for an object of the library, which never allocates: aligned to 64, its caller's for as long as it is used."""

    def __init__(self, size):
        self._bytes = ctypes.create_string_buffer(size + 63)
        self.size = size
        self.address = (ctypes.addressof(self._bytes) + 63) // 64 * 64


def path():
    """Of the library."""
    return os.environ.get("VOXSHELL_LIBRARY") or os.path.join(os.path.dirname(os.path.abspath(__file__)), "libvoxshell.so")


def declare(library, prototypes):
    """Gives the library's functions the types of their prototypes. Structs go by address."""
    for result, star, name, arguments in re.findall(r"([\w ]+?) (\*?)(vxs_\w+)\(([^)]*)\);", " ".join(prototypes.split())):
        function = getattr(library, name)
        result = result.strip()
        function.restype = (ctypes.c_char_p if result == "const char" else ctypes.c_void_p) if star else VALUES[result]
        kinds = [a.strip() for a in arguments.split(",")]
        function.argtypes = [] if kinds == ["void"] else [
            (ctypes.c_char_p if kind.startswith("const char ") else ctypes.c_void_p) if "*" in kind or "[" in kind else VALUES[kind.split()[0]]
            for kind in kinds]
    return library


_loaded = None
_devices = None


def load():
    """The library, loaded once. Raises OSError if it is not there."""
    global _loaded
    if _loaded is None:
        _loaded = declare(ctypes.CDLL(path()), PROTOTYPES)
    return _loaded


def load_devices():
    """The library of the devices, loaded once. Raises OSError if there is none beside the runtime's."""
    global _devices
    if _devices is None:
        load()  # which it is linked with
        name = os.path.join(os.path.dirname(os.path.abspath(path())), "libvoxshell-devices.so")
        if not os.path.exists(name):
            raise OSError(f"{name}: is not there: hardware and replay need the library of the devices beside the runtime's")
        _devices = declare(ctypes.CDLL(name), DEVICES)
    return _devices


def need(code, what=""):
    """Raises Error for a result that is not VXS_OK."""
    if code != 0:
        raise Error(code, what)
