"""`frictionbench export fclib/FAMILY`: recorded problems from their public collection into the user's cache."""

from rich.console import Console
from rich.progress import BarColumn, DownloadColumn, Progress, TextColumn, TransferSpeedColumn

from frictionbench.problems.recorded import collection


def fetch(name: str) -> None:
    """Fetch a family with a progress bar. Errors: InputError naming the family or the file."""
    family = collection.family(name)
    files = collection.registry()[family]
    columns = TextColumn("{task.description}"), BarColumn(), DownloadColumn(), TransferSpeedColumn()
    with Progress(*columns, console=Console(stderr=True)) as progress:
        bar = progress.add_task(f"fclib/{family}", total=sum(file.size for file in files))
        for file in collection.fetch(family):
            progress.advance(bar, file.size)
    Console().print(f"{len(files)} files in {collection.folder(family)}", soft_wrap=True, markup=False)
    Console().print(f"run them: frictionbench run recorded --data fclib/{family}", soft_wrap=True, markup=False)
