"""Many runs on all cores: a pool of warm worker processes that turn resolved scenarios into result rows.

>>> from bench.execution.job import job_of
>>> from bench.execution.pool import WorkerPool
>>> from bench.scenario import resolve
>>> jobs = [job_of(resolve("stops/dry"), key=str(seed), seed=seed) for seed in range(64)]
>>> with WorkerPool() as pool:
...     rows = {row.key: row for row in pool.run(jobs)}

A job is text (the resolved scenario as JSON) and a seed; a row is plain data. Nothing else passes between the
processes, so that a job can be stored, sent to another machine and repeated bit for bit.
"""
