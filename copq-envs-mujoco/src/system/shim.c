// An installed MuJoCo, 2.2.2 or later, opened at run time: Debian's has no functions to read mjData, so its structs come
// from the headers found at build time. Without headers copq_mujoco() returns NULL.

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif

#if defined(__has_include)
#if __has_include(<mujoco/mujoco.h>) && __has_include(<dlfcn.h>)
#define COPQ_HAS_MUJOCO
#endif
#endif

#ifndef COPQ_HAS_MUJOCO

const void* copq_mujoco(void) { return 0; }

#else

#include <dlfcn.h>
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Its own symbols first: another MuJoCo may be linked to the program.
#ifndef RTLD_DEEPBIND
#define RTLD_DEEPBIND 0
#endif

typedef void (*copq_call)(const void* model, void* data);
const char* copq_guard(copq_call call, const void* model, void* data, int times);
void copq_error(const char* text);
void copq_warning(const char* text);

static struct {
  __typeof__(mj_version)* version;
  __typeof__(mj_defaultVFS)* default_vfs;
  __typeof__(mj_deleteVFS)* delete_vfs;
#if mjVERSION_HEADER < 316
  __typeof__(mj_makeEmptyFileVFS)* make_file;
#else
  __typeof__(mj_addBufferVFS)* add_buffer;
#endif
  __typeof__(mj_loadXML)* load_xml;
  __typeof__(mj_deleteModel)* delete_model;
  __typeof__(mj_makeData)* make_data;
  __typeof__(mj_deleteData)* delete_data;
  __typeof__(mj_resetData)* reset;
  __typeof__(mj_forward)* forward;
  __typeof__(mj_step)* step;
  __typeof__(mj_rnePostConstraint)* contact_force;
  __typeof__(mj_mulM)* mul_m;
  __typeof__(mju_warningText)* warning_text;
  void (**user_error)(const char*);
  void (**user_warning)(const char*);
} mj;

static const char* find(void* library, const char* name, void* where) {
  void* symbol = dlsym(library, name);
  // Function pointers have the size of data pointers where there is dlsym.
  memcpy(where, &symbol, sizeof symbol);
  return symbol ? NULL : dlerror();
}

// Opens a library and finds what is needed in it; NULL, or what went wrong. `version` becomes the library's.
static const char* open_library(const char* path, int* version) {
  void* library = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_DEEPBIND);
  if (!library) {
    return dlerror();
  }
  const struct {
    const char* name;
    void* where;
  } symbols[] = {
      {"mj_version", &mj.version},
      {"mj_defaultVFS", &mj.default_vfs},
      {"mj_deleteVFS", &mj.delete_vfs},
#if mjVERSION_HEADER < 316
      {"mj_makeEmptyFileVFS", &mj.make_file},
#else
      {"mj_addBufferVFS", &mj.add_buffer},
#endif
      {"mj_loadXML", &mj.load_xml},
      {"mj_deleteModel", &mj.delete_model},
      {"mj_makeData", &mj.make_data},
      {"mj_deleteData", &mj.delete_data},
      {"mj_resetData", &mj.reset},
      {"mj_forward", &mj.forward},
      {"mj_step", &mj.step},
      {"mj_rnePostConstraint", &mj.contact_force},
      {"mj_mulM", &mj.mul_m},
      {"mju_warningText", &mj.warning_text},
      {"mju_user_error", &mj.user_error},
      {"mju_user_warning", &mj.user_warning},
  };
  const char* error = find(library, symbols[0].name, symbols[0].where);
  if (error) {
    return error;
  }
  *version = mj.version();
  // Another version may lack some of the rest; the caller compares versions first.
  for (size_t i = 1; *version == mjVERSION_HEADER && i < sizeof symbols / sizeof *symbols; i++) {
    error = find(library, symbols[i].name, symbols[i].where);
    if (error) {
      return error;
    }
  }
  if (*version == mjVERSION_HEADER) {
    *mj.user_error = copq_error;
    *mj.user_warning = copq_warning;
  }
  return NULL;
}

// Compiles MJCF; NULL with the reason in `error`.
static mjModel* load(const char* mjcf, int length, char* error, int size) {
  const char* name = "robot.xml";
  mjVFS* vfs = malloc(sizeof *vfs);
  if (!vfs) {
    snprintf(error, (size_t)size, "out of memory");
    return NULL;
  }
  mj.default_vfs(vfs);
#if mjVERSION_HEADER < 316
  int failed = mj.make_file(vfs, name, length);
  if (!failed) {
    memcpy(vfs->filedata[0], mjcf, (size_t)length);
  }
#else
  int failed = mj.add_buffer(vfs, name, mjcf, length);
#endif
  snprintf(error, (size_t)size, "MuJoCo's virtual file system refused the model");
  mjModel* model = failed ? NULL : mj.load_xml(name, vfs, error, size);
  mj.delete_vfs(vfs);
  free(vfs);
  return model;
}

static mjData* make_data(const mjModel* model) { return mj.make_data(model); }

static void delete_data(mjData* data) { mj.delete_data(data); }

static void delete_model(mjModel* model) { mj.delete_model(model); }

// Numbered as `Call` in Rust.
static const char* run(int call, const mjModel* model, mjData* data, int times) {
  const copq_call calls[] = {(copq_call)mj.reset, (copq_call)mj.forward, (copq_call)mj.step, (copq_call)mj.contact_force};
  return copq_guard(calls[call], model, data, times);
}

// Numbered as `Array` in Rust.
static double* array(const mjModel* model, mjData* data, int which, int* length) {
  const int nq = model->nq, nv = model->nv, nu = model->nu, nbody = model->nbody;
  const struct {
    double* values;
    int length;
  } arrays[] = {
      {&data->time, 1},
      {data->qpos, nq},
      {data->qvel, nv},
      {data->qacc_warmstart, nv},
      {data->ctrl, nu},
      {data->qfrc_applied, nv},
      {data->xpos, 3 * nbody},
      {data->xipos, 3 * nbody},
      {data->cinert, 10 * nbody},
      {data->cvel, 6 * nbody},
      {data->qfrc_actuator, nv},
      {data->cfrc_ext, 6 * nbody},
  };
  *length = arrays[which].length;
  return arrays[which].values;
}

// The first warning since the last reset, or NULL.
static const char* warning(const mjData* data) {
  for (int i = 0; i < mjNWARNING; i++) {
    if (data->warning[i].number) {
      return mj.warning_text(i, data->warning[i].lastinfo);
    }
  }
  return NULL;
}

// result = M vector
static void mul_m(const mjModel* model, const mjData* data, double* result, const double* vector) {
  mj.mul_m(model, (mjData*)data, result, vector);
}

// The same fields in the same order as `Shim` in Rust.
static const struct {
  int header;
  const char* (*open)(const char*, int*);
  mjModel* (*load)(const char*, int, char*, int);
  void (*delete_model)(mjModel*);
  mjData* (*make_data)(const mjModel*);
  void (*delete_data)(mjData*);
  const char* (*run)(int, const mjModel*, mjData*, int);
  double* (*array)(const mjModel*, mjData*, int, int*);
  const char* (*warning)(const mjData*);
  void (*mul_m)(const mjModel*, const mjData*, double*, const double*);
} shim = {mjVERSION_HEADER, open_library, load, delete_model, make_data, delete_data, run, array, warning, mul_m};

const void* copq_mujoco(void) { return &shim; }

#endif
