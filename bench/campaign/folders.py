"""Where campaigns are on the disk: by folder, by name below ``runs/campaigns``, or the latest."""

from pathlib import Path

from bench.campaign.campaign_file import CampaignFile
from bench.campaign.store import find_row, read_about
from signals.errors import InputError, nearest_name

CAMPAIGNS = Path("runs") / "campaigns"


def campaign_folders() -> list[Path]:
    """Folders of campaigns below the present one, the latest first."""
    found = [path.parent for path in CAMPAIGNS.glob("*/campaign.json")]
    return sorted(found, key=lambda folder: (folder / "runs").stat().st_mtime, reverse=True)


def find_campaign(argument: str | None) -> Path:
    """Folder of a campaign.

    Raises
    ------
    InputError
        If there is none of this name, or none at all.
    """
    if argument is None:
        folders = campaign_folders()
        if not folders:
            raise InputError(f"no campaign in {CAMPAIGNS}", mend="make one: bench campaign run FILE")
        return folders[0]
    for folder in (Path(argument), CAMPAIGNS / argument):
        if folder.is_dir():
            read_about(folder)
            return folder
    names = [folder.name for folder in campaign_folders()]
    raise InputError(f"no campaign {argument!r}", nearest=nearest_name(argument, names))


def campaign_of(folder: Path) -> CampaignFile:
    """The campaign that a folder holds."""
    return CampaignFile.model_validate(read_about(folder)["campaign"])


def find_run(key: str, campaign: str | None) -> tuple[Path, dict[str, object]]:
    """Folder and row of a run.

    Raises
    ------
    InputError
        If no campaign has it.
    """
    folders = campaign_folders() if campaign is None else [find_campaign(campaign)]
    for folder in folders:
        row = find_row(folder, key)
        if row is not None:
            return folder, row
    where = str(CAMPAIGNS) if campaign is None else campaign
    raise InputError(
        f"no single run {key!r} in {where}", mend="give its whole key, and --campaign DIR if it is elsewhere"
    )
