// MuJoCo's answer to an internal error is to end the process. From calls made through copq_guard it comes back instead.

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>

typedef void (*copq_call)(const void* model, void* data);

static _Thread_local jmp_buf* landing = NULL;
static _Thread_local char message[512];

// Calls `call` a number of times; NULL, or what MuJoCo said when it gave up. The jump skips frames of MuJoCo only.
const char* copq_guard(copq_call call, const void* model, void* data, int times) {
  jmp_buf here;
  if (setjmp(here) == 0) {
    landing = &here;
    for (int i = 0; i < times; i++) {
      call(model, data);
    }
    landing = NULL;
    return NULL;
  }
  landing = NULL;
  return message;
}

// For mju_user_error. Outside of copq_guard it ends the process, as MuJoCo without a handler does: were it to return, MuJoCo
// would go on where it must not.
void copq_error(const char* text) {
  if (landing) {
    snprintf(message, sizeof message, "%s", text);
    longjmp(*landing, 1);
  }
  fprintf(stderr, "MuJoCo: %s\n", text);
  exit(EXIT_FAILURE);
}

// For mju_user_warning, so that MuJoCo writes no MUJOCO_LOG.TXT. Inside copq_guard the caller reads mjData's warnings.
void copq_warning(const char* text) {
  if (!landing) {
    fprintf(stderr, "MuJoCo: %s\n", text);
  }
}
