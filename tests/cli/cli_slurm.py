# SPDX-License-Identifier: GPL-3.0-or-later
"""voxshell batch --executor slurm on a Slurm of one node, started here on loopback: the same files and the same report as a local run,
whatever happens to a job on its way."""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import unittest

import command
import shapes

CONFIG = '''ClusterName=voxshell
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/sock
CredType=cred/munge
SlurmctldPort={control}
SlurmdPort={node}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldLogFile={folder}/log/slurmctld.log
SlurmdLogFile={folder}/log/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_interval=1,bf_interval=1
JobCompType=jobcomp/none
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory=500 State=UNKNOWN
PartitionName=debug Nodes={host} Default=YES MaxTime=INFINITE State=UP
'''


def free_port():
    with socket.socket() as one:
        one.bind(('127.0.0.1', 0))
        return one.getsockname()[1]


class Cluster:
    """Starts munged, slurmctld and slurmd; raises SkipTest with the reason where that cannot be."""

    def __init__(self):
        missing = [name for name in ('munged', 'slurmctld', 'slurmd', 'sbatch') if not shutil.which(name, path=os.environ['PATH'] + ':/usr/sbin')]
        if missing:
            raise unittest.SkipTest(f'{", ".join(missing)}: not installed')
        if os.geteuid() != 0:
            raise unittest.SkipTest('a Slurm of its own needs root')
        self.folder = tempfile.mkdtemp(prefix='vxs', dir='/tmp')  # short: a socket's path is
        host = socket.gethostname().split('.')[0]
        for name in ('state', 'spool', 'log', 'munge'):
            os.mkdir(f'{self.folder}/{name}', 0o755)
        with open(f'{self.folder}/munge/key', 'wb') as file:
            file.write(os.urandom(1024))
        os.chmod(f'{self.folder}/munge/key', 0o600)
        self.config = f'{self.folder}/slurm.conf'
        pathlib.Path(self.config).write_text(CONFIG.format(folder=self.folder, host=host, cpus=os.cpu_count(), control=free_port(), node=free_port()),
                                             encoding='ascii')
        munge = f'{self.folder}/munge'
        environment = {**os.environ, 'SLURM_CONF': self.config, 'PATH': os.environ['PATH'] + ':/usr/sbin'}
        try:
            for line in (['munged', f'--key-file={munge}/key', f'--socket={munge}/sock', f'--pid-file={munge}/pid', f'--log-file={munge}/log',
                          f'--seed-file={munge}/seed', '--force'],
                         ['slurmctld', '-f', self.config], ['slurmd', '-f', self.config]):
                subprocess.run(line, check=True, env=environment, capture_output=True, timeout=20)
            for _ in range(100):
                if 'idle' in subprocess.run(['sinfo', '-h', '-o', '%T'], env=environment, capture_output=True, text=True, check=False).stdout:
                    return
                time.sleep(0.1)
            raise unittest.SkipTest('no node became idle in 10 s')
        except (subprocess.SubprocessError, OSError) as error:
            self.stop()
            raise unittest.SkipTest(f'a Slurm does not start here: {error}')
        except unittest.SkipTest:
            self.stop()
            raise

    def stop(self):
        for name in ('slurmd.pid', 'slurmctld.pid', 'munge/pid'):
            try:
                pid = int(pathlib.Path(self.folder, name).read_text(encoding='ascii'))
                os.kill(pid, signal.SIGTERM)
                for _ in range(50):
                    os.kill(pid, 0)
                    time.sleep(0.1)
                os.kill(pid, signal.SIGKILL)
            except (OSError, ValueError):
                pass
        shutil.rmtree(self.folder, ignore_errors=True)


class Slurm(command.CommandTest):
    @classmethod
    def setUpClass(cls):
        cls.cluster = Cluster()
        os.environ['SLURM_CONF'] = cls.cluster.config

    @classmethod
    def tearDownClass(cls):
        cls.cluster.stop()

    def parts(self, count=10):
        meshes = [(f'cup {n}', shapes.cup(radius=12 + n, height=20 + n, wall=3, segments=32)) for n in range(count)]
        nodes = [{'name': f'node {n}', 'mesh': n % count, 'translation': [0.1 * n, 0, 0]} for n in range(2 * count)]
        shapes.write_assembly(self.path('kit.glb'), meshes, nodes)
        os.makedirs(self.path('in'))
        shapes.write_stl(self.path('in', 'one.stl'), shapes.cup(radius=30, segments=40))
        with open(self.path('in', 'bad.stl'), 'wb') as file:
            file.write(b'solid x\nfacet')
        return ('kit.glb', 'in', '--per-part', '--unit', 'mm', '--voxel', '0.7mm', '--reproducible')

    def results(self, folder):
        return {name: digest for name, digest in self.digests(folder).items() if not name.startswith('.voxshell')}

    def compare(self, one, other):
        self.assertEqual(self.results(self.path(one)), self.results(self.path(other)))
        reports = [pathlib.Path(self.path(f'{name}.json')).read_text(encoding='utf-8') for name in (one, other)]
        self.assertEqual(reports[0], reports[1])
        self.assertFalse(os.path.exists(self.path(other, '.voxshell-work')))

    def test_the_same_as_at_home(self):
        arguments = self.parts()
        self.run_voxshell('batch', *arguments, '-o', 'home', '--report', 'home.json', '-q', code=3)
        done = self.run_voxshell('batch', *arguments, '-o', 'farm', '--report', 'farm.json', '--executor', 'slurm', '--shards', '4', code=3)
        self.assertRegex(done.stderr, r'voxshell batch: job \d+: 4 shards\n')
        self.assertEqual(done.stdout, '11 built, 1 failed\n')
        self.compare('home', 'farm')
        os.unlink(self.path('in', 'bad.stl'))
        self.run_voxshell('batch', *arguments, '-o', 'farm', '--executor', 'slurm', out='^0 built, 11 up to date, 0 failed\n$', err='')  # nothing to submit

    def test_a_task_is_killed_on_its_way(self):
        arguments = self.parts()
        self.run_voxshell('batch', *arguments, '-o', 'home', '--report', 'home.json', '-q', code=3)
        process = subprocess.Popen([command.BIN, 'batch', *arguments, '-o', 'farm', '--report', 'farm.json', '--executor', 'slurm', '--shards', '3', '-j1'],
                                   cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        killed = 0
        end = time.monotonic() + 60
        while not killed and time.monotonic() < end and process.poll() is None:
            for pid in subprocess.run(['pgrep', '-f', 'voxshell batch .*--shard [01]/3:'], capture_output=True, text=True, check=False).stdout.split():
                try:
                    os.kill(int(pid), signal.SIGKILL)
                    killed += 1
                except ProcessLookupError:
                    pass
            time.sleep(0.005)
        out, err = process.communicate(timeout=120)
        self.assertGreater(killed, 0)
        self.assertEqual((process.returncode, out), (3, '11 built, 1 failed\n'), err)
        self.assertRegex(err, r'job \d+: [12] shards, again\n')
        self.compare('home', 'farm')

    def test_an_interrupt_ends_the_job(self):
        arguments = self.parts()
        process = subprocess.Popen([command.BIN, 'batch', *arguments, '-o', 'farm', '--executor', 'slurm', '--sbatch=--begin=now+1hour'],
                                   cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while 'job' not in (line := process.stderr.readline()):
            self.assertNotEqual(line, '')
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
        self.assertEqual((process.returncode, err), (130, 'voxshell batch: interrupted\n'))
        for _ in range(100):
            queue = subprocess.run(['squeue', '--noheader'], capture_output=True, text=True, check=True).stdout
            if not queue:
                break
            time.sleep(0.1)
        self.assertEqual(queue, '')
        self.run_voxshell('batch', *arguments, '-o', 'farm', '-q', code=3)  # and the next run completes

    def test_refused(self):
        arguments = self.parts(1)
        self.run_voxshell('batch', *arguments, '-o', 'out', '--executor', 'slurm', '--sbatch=--partition=none', code=2, err='sbatch: refused the job: .*partition')
        self.run_voxshell('batch', *arguments, '-o', 'out', '--executor', 'slurm', code=2, err='sbatch: is not there: is Slurm installed', env={'PATH': '/nowhere'})
        self.run_voxshell('batch', *arguments, '-o', 'out', '--shard', '0/2:0123456789abcdef', code=2, err='cannot read: is this the folder that the work was planned in')
        self.run_voxshell('batch', *arguments, '-o', 'out', '--shard', '2/2:0123456789abcdef', code=1, err='is not K/N:HASH')


if __name__ == '__main__':
    command.main()
