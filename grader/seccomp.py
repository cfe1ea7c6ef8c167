"""The system calls that a student's process may not make, as a program for the kernel."""

from __future__ import annotations

import tempfile
from functools import cache

# Everything else is allowed: namespaces, the empty root and the resource limits bound it.
_DENIED = """
fork vfork clone clone3 execve execveat
socket socketpair connect bind listen accept accept4 sendto recvfrom sendmsg recvmsg sendmmsg
ptrace process_vm_readv process_vm_writev process_madvise kcmp pidfd_open pidfd_getfd pidfd_send_signal
mount umount2 pivot_root chroot setns unshare fsopen fsmount fsconfig fspick move_mount open_tree mount_setattr
bpf perf_event_open userfaultfd io_uring_setup io_uring_enter io_uring_register
keyctl add_key request_key personality syslog acct quotactl swapon swapoff reboot
init_module finit_module delete_module kexec_load kexec_file_load iopl ioperm
settimeofday clock_settime clock_adjtime adjtimex sethostname setdomainname
memfd_create memfd_secret shmget shmat msgget semget mq_open
inotify_init inotify_init1 fanotify_init fanotify_mark io_setup io_submit listmount statmount flock
name_to_handle_at open_by_handle_at
mknod mknodat mkdir mkdirat symlink symlinkat link linkat
setuid setgid setreuid setregid setresuid setresgid setfsuid setfsgid setgroups capset
"""


@cache
def program() -> bytes:
    """The filter, as the bytes of BPF instructions; denied calls fail with EPERM.

    Raises
    ------
    RuntimeError
        pyseccomp or libseccomp is missing.
    """
    try:
        import pyseccomp
    except (ImportError, OSError, RuntimeError) as error:
        raise RuntimeError(f"pyseccomp does not work ({error})") from None
    rules = pyseccomp.SyscallFilter(pyseccomp.ALLOW)
    for name in _DENIED.split():
        # glibc falls back from clone3 to clone only when clone3 does not exist.
        errno = 38 if name == "clone3" else 1
        try:
            rules.add_rule(pyseccomp.ERRNO(errno), name)
        except (OSError, ValueError):
            continue  # unknown to this libseccomp, or to this processor
    with tempfile.TemporaryFile() as file:
        rules.export_bpf(file)
        file.seek(0)
        return file.read()
