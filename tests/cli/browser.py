# SPDX-License-Identifier: GPL-3.0-or-later
"""A page in headless chromium, by the DevTools protocol over a pipe; nothing but the standard library. find() is None where there is none."""
import base64
import fcntl
import json
import os
import pathlib
import select
import shutil
import subprocess
import tempfile
import time

PROGRAMS = ('chromium', 'chromium-headless-shell', 'chromium-browser', 'google-chrome')


def find():
    return next(filter(None, map(shutil.which, PROGRAMS)), None)


NO_GPU = ('--disable-gpu',)
SOFTWARE_GL = ('--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist')


class Browser:
    """`graphics`: NO_GPU, where pages draw no 3D, or SOFTWARE_GL."""
    def __init__(self, program, seconds=60, graphics=NO_GPU):
        self.seconds, self.number, self.rest, self.errors, self.loaded, self.session = seconds, 0, b'', [], 0, None
        self.folder = tempfile.mkdtemp(prefix='voxshell-')
        there, back = os.pipe(), os.pipe()
        ends = [fcntl.fcntl(fd, fcntl.F_DUPFD, 10) for fd in (there[0], back[1])]

        def wire():  # the browser reads from 3 and writes to 4
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)

        self.process = subprocess.Popen([program, '--headless', '--no-sandbox', *graphics, '--disable-dev-shm-usage', '--remote-debugging-pipe', f'--user-data-dir={self.folder}'],
                                        preexec_fn=wire, pass_fds=(3, 4), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for fd in (*ends, there[0], back[1]):
            os.close(fd)
        self.out, self.into = there[1], back[0]
        target = self.ask('Target.createTarget', url='about:blank')['targetId']
        self.session = self.ask('Target.attachToTarget', targetId=target, flatten=True)['sessionId']
        for domain in ('Page', 'Runtime', 'Log'):
            self.ask(domain + '.enable')

    def close(self):
        self.process.kill()
        self.process.wait()
        os.close(self.out)
        os.close(self.into)
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def ask(self, method, **parameters):
        self.number += 1
        message = {'id': self.number, 'method': method, 'params': parameters, **({'sessionId': self.session} if self.session else {})}
        os.write(self.out, json.dumps(message).encode() + b'\0')
        while True:
            answer = self.next()
            if answer.get('id') == self.number:
                if 'error' in answer:
                    raise RuntimeError(f'{method}: {answer["error"]}')
                return answer['result']

    def next(self):
        """The next message; what pages complain about is kept."""
        end = time.monotonic() + self.seconds
        while b'\0' not in self.rest:
            if not select.select([self.into], [], [], max(0, end - time.monotonic()))[0]:
                raise TimeoutError('the browser says nothing')
            more = os.read(self.into, 1 << 20)
            if not more:
                raise EOFError('the browser is gone')
            self.rest += more
        line, self.rest = self.rest.split(b'\0', 1)
        message = json.loads(line)
        kind, told = message.get('method'), message.get('params', {})
        if kind == 'Runtime.exceptionThrown' or kind == 'Runtime.consoleAPICalled' and told['type'] in ('error', 'warning') or kind == 'Log.entryAdded' and told['entry']['level'] == 'error':
            self.errors.append(told)
        self.loaded += kind == 'Page.loadEventFired'
        return message

    def open(self, path, width, height):
        self.ask('Emulation.setDeviceMetricsOverride', width=width, height=height, deviceScaleFactor=1, mobile=width < 600)
        before = self.loaded
        self.ask('Page.navigate', url=pathlib.Path(path).absolute().as_uri())
        while self.loaded == before:
            self.next()

    def run(self, script):
        """What the expression is, as Python has it."""
        answer = self.ask('Runtime.evaluate', expression=script, returnByValue=True, awaitPromise=True)
        if 'exceptionDetails' in answer:
            raise RuntimeError(answer['exceptionDetails'])
        return answer['result'].get('value')

    def screenshot(self, path):
        shot = self.ask('Page.captureScreenshot', captureBeyondViewport=True, **{'format': 'png'})
        pathlib.Path(path).write_bytes(base64.b64decode(shot['data']))

    def colours(self, box):
        """Of a part of the screen (x, y, width, height): how many pixels each colour (r, g, b) has, and in what box (left, top, right, bottom) they lie."""
        clip = dict(zip(('x', 'y', 'width', 'height'), box), scale=1)
        shot = self.ask('Page.captureScreenshot', clip=clip, **{'format': 'png'})
        rows = self.run('''(async () => {
            const image = new Image();
            image.src = 'data:image/png;base64,%s';
            await image.decode();
            const pen = Object.assign(document.createElement('canvas'), {width: image.width, height: image.height}).getContext('2d');
            pen.drawImage(image, 0, 0);
            const data = pen.getImageData(0, 0, image.width, image.height).data, found = new Map();
            for (let y = 0, n = 0; y < image.height; ++y) for (let x = 0; x < image.width; ++x, n += 4) {
                const key = data[n] << 16 | data[n + 1] << 8 | data[n + 2], row = found.get(key);
                if (!row) found.set(key, [1, x, y, x + 1, y + 1]);
                else { ++row[0]; row[1] = Math.min(row[1], x); row[3] = Math.max(row[3], x + 1); row[4] = y + 1; }
            }
            return [...found];
        })()''' % shot['data'])
        return {(key >> 16, key >> 8 & 255, key & 255): (row[0], tuple(row[1:])) for key, row in rows}

    def pdf(self):
        return base64.b64decode(self.ask('Page.printToPDF', printBackground=True)['data'])
